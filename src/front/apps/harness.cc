// tessera harness: runs the real actors under a deterministic scheduler, for one random seed after the other, and
// compares the results with CGAL's.
#include "actors/harness/harness.h"
#include "src/base/json/json_text.h"

#include <algorithm>
#include <cstdio>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "src/front/apps/command.h"
#include "src/front/apps/interrupt.h"
#include "src/front/apps/log.h"
#include "src/geometry/reference/clouds.h"
#include "src/job/arguments.h"
#include "src/job/report/human.h"

namespace tessera {
namespace {

constexpr std::int64_t points_max = 1'000'000;  // the comparison needs every cell in memory
constexpr std::int64_t harness_tiles_max = 4096;
constexpr std::int64_t nodes_max = 64;

// Parses "17" or "1..1000". Both ends are included.
Result<std::pair<std::uint64_t, std::uint64_t>> parse_seeds(const std::string& text) {
  constexpr auto highest = std::numeric_limits<std::int64_t>::max() - 1;
  const auto dots = text.find("..");
  auto first = parse_integer(text.substr(0, dots), 0, highest);
  auto last = dots == std::string::npos ? first : parse_integer(text.substr(dots + 2), 0, highest);
  if (!first || !last || first.value() > last.value()) {
    return error(Errc::usage, "'" + text + "' is not a range of seeds like 1..1000");
  }
  return std::pair(static_cast<std::uint64_t>(first.value()), static_cast<std::uint64_t>(last.value()));
}

constexpr const char* fault_names = "storage, kill, pause, join, coordinator, leave, last, all";

// Parses a list like "kill,join".
Result<HarnessFaults> parse_faults(const std::string& text) {
  HarnessFaults faults;
  std::istringstream in(text);
  for (std::string name; std::getline(in, name, ',');) {
    bool* const fault = name == "storage"       ? &faults.storage
                        : name == "kill"        ? &faults.kill
                        : name == "pause"       ? &faults.pause
                        : name == "join"        ? &faults.join
                        : name == "coordinator" ? &faults.coordinator
                        : name == "leave"       ? &faults.leave
                        : name == "last"        ? &faults.last
                        : name == "all"         ? &faults.all
                                                : nullptr;
    if (!fault) return error(Errc::usage, "'" + name + "' is not a fault; the faults are " + std::string(fault_names));
    *fault = true;
  }
  return faults;
}

std::string kinds() {
  std::string names;
  for (const auto& kind : cloud_kinds()) names += (names.empty() ? "" : ", ") + kind;
  return names;
}

Result<HarnessOptions> read_options(Settings& settings) {
  HarnessOptions options;
  BOOST_OUTCOME_TRYV(settings.exclusive("seed", "seeds"));
  options.kind = settings.text("kind").value_or(options.kind);
  if (std::find(cloud_kinds().begin(), cloud_kinds().end(), options.kind) == cloud_kinds().end()) {
    return error(Errc::usage, "--kind: '" + options.kind + "' is not a kind of cloud; the kinds are " + kinds());
  }
  const auto integer = [](std::int64_t lowest, std::int64_t highest) {
    return [=](const std::string& text) { return parse_integer(text, lowest, highest); };
  };
  BOOST_OUTCOME_TRY(dimension, settings.get("dim", integer(2, 3)));
  options.dimension = static_cast<int>(dimension.value_or(options.dimension));
  BOOST_OUTCOME_TRY(points, settings.get("points", integer(options.dimension + 1, points_max)));
  if (points) options.points = static_cast<std::size_t>(*points);
  BOOST_OUTCOME_TRY(tiles, settings.get("tiles", integer(1, harness_tiles_max)));
  if (tiles) options.tiles = static_cast<std::uint32_t>(*tiles);
  BOOST_OUTCOME_TRY(nodes, settings.get("nodes", integer(1, nodes_max)));
  if (nodes) options.nodes = static_cast<std::uint32_t>(*nodes);
  BOOST_OUTCOME_TRY(mail, settings.get("mail", integer(0, std::int64_t{1} << 40)));
  if (mail) options.mail_bytes_max = static_cast<std::uint64_t>(*mail);
  BOOST_OUTCOME_TRY(faults, settings.get("faults", parse_faults));
  options.faults = faults.value_or(HarnessFaults{});
  BOOST_OUTCOME_TRY(restarts, settings.on("restarts"));
  options.restarts = restarts;
  BOOST_OUTCOME_TRY(partition, settings.get("partition", parse_partition_kind));
  if (partition) options.partition = *partition;
  BOOST_OUTCOME_TRY(seeds, settings.get("seeds", parse_seeds));
  if (seeds) std::tie(options.first_seed, options.last_seed) = *seeds;
  BOOST_OUTCOME_TRY(seed, settings.get("seed", integer(0, std::numeric_limits<std::int64_t>::max() - 1)));
  if (seed) options.first_seed = options.last_seed = static_cast<std::uint64_t>(*seed);
  BOOST_OUTCOME_TRY(trace, settings.on("trace"));
  if (trace) options.trace = [](const std::string& step) { std::printf("%s\n", step.c_str()); };
  return options;
}

Result<HarnessReport> run_seeds(const HarnessOptions& options) {
  const Interrupt interrupt;
  HarnessReport sum;
  for (auto seed = options.first_seed; seed <= options.last_seed && !sum.failed_seed; ++seed) {
    auto one = options;
    one.first_seed = one.last_seed = seed;
    one.stop = interrupt.token();
    auto report = run_harness(one);
    if (one.stop.stop_requested() && report.seeds == 0 && !report.failed_seed) {
      return error(Errc::interrupted, "interrupted at seed " + std::to_string(seed) + "; all seeds before it passed");
    }
    sum.seeds += report.seeds;
    sum.steps += report.steps;
    sum.updates += report.updates;
    sum.waves += report.waves;
    sum.sleeps += report.sleeps;
    sum.spills += report.spills;
    sum.failures += report.failures;
    sum.restarts += report.restarts;
    sum.settled_restarts += report.settled_restarts;
    sum.epochs += report.epochs;
    sum.failed_seed = report.failed_seed;
    sum.failure = std::move(report.failure);
  }
  return sum;
}

Status run_harness_command(Settings& settings) {
  BOOST_OUTCOME_TRY(options, read_options(settings));
  BOOST_OUTCOME_TRY(output, output_options(settings));
  if (output.verbose) log_everything();
  BOOST_OUTCOME_TRY(report, run_seeds(options));
  if (report.failed_seed) {
    return error(Errc::not_delaunay, "seed " + std::to_string(*report.failed_seed) + ": " + report.failure +
                                         "; replay it with --seed " + std::to_string(*report.failed_seed) + " --trace");
  }
  if (output.json) {
    const nlohmann::ordered_json object{{"event", "harness"},          {"seeds", report.seeds},
                                        {"steps", report.steps},       {"messages", report.updates},
                                        {"waves", report.waves},       {"sleeps", report.sleeps},
                                        {"spills", report.spills},     {"failures", report.failures},
                                        {"restarts", report.restarts}, {"epochs", report.epochs}};
    std::printf("%s\n", json_text(object).c_str());
  } else if (!output.quiet) {
    std::printf(
        "%s seeds passed: %s steps, %s messages with points, %s collections of counters, %s sleeps, "
        "%s spills of mail, %s runs ended by faults, %s resumed (%s settled), %s times nodes were lost or joined, or a "
        "coordinator was replaced\n",
        grouped(report.seeds).c_str(), grouped(report.steps).c_str(), grouped(report.updates).c_str(),
        grouped(report.waves).c_str(), grouped(report.sleeps).c_str(), grouped(report.spills).c_str(),
        grouped(report.failures).c_str(), grouped(report.restarts).c_str(), grouped(report.settled_restarts).c_str(),
        grouped(report.epochs).c_str());
  }
  return success();
}

}  // namespace

Command add_harness(CLI::App& root) {
  auto command = new_command(root, "harness", "Runs the actors in seeded random schedules and compares with CGAL",
                             "  tessera harness --kind lattice -n 40 --tiles 7 --seeds 1..1000\n"
                             "  tessera harness --kind lattice -n 40 --tiles 7 --seed 17 --trace      (replays one)");
  set_group(command, "For tests");
  add_value(command, "kind", "NAME", kinds() + "; default: uniform", 0, true);
  add_choices(command, "kind", kinds());
  add_value(command, "points", "N", "about how many points; default: 40", 'n', true);
  add_value(command, "dim", "2|3", "the dimension; default: 3", 0, true);
  add_value(command, "tiles", "N", "the number of tiles; default: 7", 0, true);
  add_value(command, "partition", "KIND", "kdtree (default), grid, octree or random", 0, true);
  add_choices(command, "partition", "kdtree, grid, octree, random");
  add_value(command, "seeds", "A..B", "run these seeds, up to the first that fails; default: 1..1", 0, true);
  add_value(command, "seed", "N", "run this seed alone", 0, true);
  add_value(command, "nodes", "N", "the number of nodes that the tiles are spread over; default: random, 1 to 3", 0,
            true);
  add_value(command, "mail", "N", "how many bytes of waiting messages a tile keeps in memory; default: random", 0,
            true);
  add_value(command, "faults", "LIST",
            "what goes wrong in each run: storage (it fails once, and the run is resumed), kill (nodes are killed), "
            "pause (nodes are silent for longer than their lease), join (nodes join later), coordinator (it is "
            "killed), leave (nodes leave in order), last (all nodes are lost one after the other, and another one "
            "joins), all (all nodes are lost at once, and others join)",
            0, true);
  add_switch(command, "restarts", "kill or cancel the processes, and resume the run", 0, true);
  add_switch(command, "trace", "print every step", 0, true);
  add_output_switches(command);
  command.run = [settings = command.settings.get()](const std::vector<std::string>&) {
    return run_harness_command(*settings);
  };
  return command;
}

}  // namespace tessera
