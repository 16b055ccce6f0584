// tessera tileset: writes a 2D result for 3D viewers.
#include "src/result/tileset/tileset.h"
#include "src/front/apps/say.h"

#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "src/front/apps/command.h"
#include "src/front/apps/interrupt.h"
#include "src/front/apps/log.h"
#include "src/front/apps/machine_options.h"
#include "src/front/apps/one_step.h"
#include "src/front/apps/percent_line.h"
#include "src/job/arguments.h"
#include "src/job/report/human.h"

namespace tessera::apps {
namespace {

void print(const Tileset& made, const OutputOptions& output) {
  if (output.json) {
    std::printf("%s\n", to_json(made).c_str());
  } else if (!output.quiet) {
    say("%s: %s triangles in %s leaves, %s nodes in all, %s\n", made.path.c_str(), grouped(made.triangles).c_str(),
        grouped(made.leaves).c_str(), grouped(made.nodes).c_str(), human_bytes(made.bytes).c_str());
    if (made.left_out > 0)
      say("%s cells with longer edges or larger circumradii are left out\n", grouped(made.left_out).c_str());
  }
}

Status run_tileset(Settings& settings, const OneStep& made_of) {
  const std::string target = settings.text("output").value_or("");
  if (made_of.sources.empty()) return error(Errc::usage, "no result folder is given; try 'tessera tileset --help'");
  if (target.empty()) return error(Errc::usage, "no folder to write is given; add -o FOLDER");
  BOOST_OUTCOME_TRY(output, output_options(settings));
  if (output.verbose) log_everything();
  TilesetOptions options;
  BOOST_OUTCOME_TRY(max_edge, settings.get("max-edge", [](const std::string& text) { return parse_distance(text); }));
  options.max_edge = max_edge;
  BOOST_OUTCOME_TRY(radius, settings.get("max-radius", [](const std::string& text) { return parse_distance(text); }));
  options.max_radius = radius;
  BOOST_OUTCOME_TRY(overwrite, settings.on("overwrite"));
  options.overwrite = overwrite;
  BOOST_OUTCOME_TRY(memory, memory_option(settings));
  options.memory_bytes = memory;
  options.progress = share_line("making the tileset", output);

  return on_result(settings, made_of, output, [&](const std::string& folder) -> Status {
    const Interrupt interrupt;
    auto result = write_tileset(folder, target, options, interrupt.token());
    clear_line(output);
    BOOST_OUTCOME_TRY(made, std::move(result));
    print(made, output);
    return success();
  });
}

}  // namespace

Command add_tileset(CLI::App& root) {
  auto command = new_command(root, "tileset", "Writes a 2D result as 3D Tiles, for viewers",
                             "  tessera tileset ground/ -o tiles/                  (tiles/tileset.json, nodes/*.glb)\n"
                             "  tessera tileset ground/ --max-edge 5 -o tiles/     (without cells that bridge gaps)");
  add_value(command, "max-edge", "LENGTH", "leave out cells with a longer edge in the plane; default: none");
  add_value(command, "max-radius", "LENGTH", "leave out cells with a larger circumradius in the plane; default: none");
  add_value(command, "output", "FOLDER", "the folder to write", 'o', true);
  add_threads_option(command);
  add_memory_option(command, "a tile");
  add_switch(command, "overwrite", "replace a tileset that exists", 0, true);
  add_output_switches(command);
  auto sources = add_sources(command, 2);
  command.run = [settings = command.settings.get(), sources](const std::vector<std::string>& command_line) -> Status {
    return run_tileset(*settings, {.sources = *sources,
                                   .dimension = 2,
                                   .beside = settings->text("output").value_or(""),
                                   .command_line = command_line});
  };
  return command;
}

}  // namespace tessera::apps
