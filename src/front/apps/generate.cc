// tessera generate: writes clouds of random points, for tests and trials.
#include "src/input/generate/generate.h"
#include "src/base/json/json_text.h"
#include "src/front/apps/say.h"

#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "src/base/files/there.h"
#include "src/front/apps/command.h"
#include "src/front/apps/interrupt.h"
#include "src/front/apps/log.h"
#include "src/job/arguments.h"
#include "src/job/report/human.h"

namespace tessera::apps {
namespace {

Status run_generate(Settings& settings, const std::string& kind) {
  GenerateOptions options;
  if (kind.empty()) return error(Errc::usage, "no kind of cloud is given; try 'tessera generate --help'");
  const auto shape = shape_named(kind);
  if (!shape)
    return error(
        Errc::usage,
        "'" + kind + "' is not a kind of cloud; the kinds are uniform, normal, sphere, grid, terrain and halos");
  options.shape = *shape;
  BOOST_OUTCOME_TRY(points, settings.get("points", [](const std::string& text) { return parse_count(text); }));
  if (!points) return error(Errc::usage, "no number of points is given; add -n 10M");
  if (*points == 0) return error(Errc::usage, "--points: must be at least 1");
  options.points = *points;
  BOOST_OUTCOME_TRY(seed, settings.get("seed", [](const std::string& text) {
    return parse_integer(text, 0, std::numeric_limits<std::int64_t>::max());
  }));
  options.seed = static_cast<std::uint64_t>(seed.value_or(1));
  BOOST_OUTCOME_TRY(dimension, settings.get("dim", [](const std::string& text) { return parse_integer(text, 2, 3); }));
  options.dimension = static_cast<int>(dimension.value_or(3));
  BOOST_OUTCOME_TRY(overwrite, settings.on("overwrite"));
  BOOST_OUTCOME_TRY(output, output_options(settings));
  const std::filesystem::path target = settings.text("output").value_or("");
  if (target.empty()) return error(Errc::usage, "no file to write is given; add -o FILE");
  BOOST_OUTCOME_TRY(there, is_regular(target));
  if (there && !overwrite) {
    return error(Errc::usage, target.string() + ": exists already; --overwrite replaces it");
  }
  if (output.verbose) log_everything();

  const Interrupt interrupt;
  const auto stop = interrupt.token();
  BOOST_OUTCOME_TRYV(generate(options, target, [&](std::uint64_t) { return !stop.stop_requested(); }));
  BOOST_OUTCOME_TRY(written, bytes_if_there(target));
  const auto bytes = written.value_or(0);  // a device has no size
  if (output.json) {
    const nlohmann::ordered_json object{
        {"event", "generated"}, {"output", target.string()}, {"points", options.points}, {"bytes", bytes}};
    std::printf("%s\n", json_text(object).c_str());
  } else if (!output.quiet) {
    say("%s: %s points, %s\n", target.c_str(), grouped(options.points).c_str(), human_bytes(bytes).c_str());
  }
  return success();
}

}  // namespace

Command add_generate(CLI::App& root) {
  auto command =
      new_command(root, "generate", "Writes a made-up cloud: uniform, normal, sphere, grid, terrain or halos",
                  "  tessera generate uniform -n 10M --seed 7 -o cloud.las\n"
                  "  tessera generate terrain -n 1.5M -o hills.las\n"
                  "  tessera generate sphere -n 10k --dim 2 -o circle.xyz");
  set_group(command, "For tests");
  add_value(command, "points", "N", "how many points, for example 500, 10k or 1.5M", 'n', true);
  add_value(command, "seed", "N", "another seed gives another cloud of the same kind; default: 1");
  add_value(command, "dim", "2|3", "the dimension: 2 leaves z out; default: 3");
  add_value(command, "output", "FILE", "the file to write: .las, .ply, .npy, .xyz or .csv", 'o', true);
  add_switch(command, "overwrite", "replace the file if it exists", 0, true);
  add_output_switches(command);
  auto kind = std::make_shared<std::string>();
  add_argument(command, "kind", "KIND", *kind, "uniform, normal, sphere, grid, terrain or halos");
  add_choices(command, "kind", "uniform, normal, sphere, grid, terrain, halos");
  command.run = [settings = command.settings.get(), kind](const std::vector<std::string>&) {
    return run_generate(*settings, *kind);
  };
  return command;
}

}  // namespace tessera::apps
