// tessera materialise: writes the files of cells of a result that is kept as points.
#include "src/delaunay/run/materialise.h"
#include "src/base/json/json_text.h"

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "src/front/apps/command.h"
#include "src/front/apps/interrupt.h"
#include "src/front/apps/log.h"
#include "src/front/apps/machine_options.h"
#include "src/front/apps/percent_line.h"
#include "src/front/apps/say.h"
#include "src/job/arguments.h"
#include "src/job/version.h"
#include "src/result/far_files.h"
#include "src/result/store/tile_store.h"

namespace tessera::apps {
namespace {

void print(const Materialised& made, const OutputOptions& output) {
  const std::string folder = made.folder.string();
  if (output.json) {
    const nlohmann::ordered_json told{{"event", "materialised"},
                                      {"output", folder},
                                      {"version", made.version},
                                      {"tiles", made.tiles},
                                      {"left_as_points", made.left_as_points},
                                      {"bytes", made.bytes}};
    std::printf("%s\n", json_text(told).c_str());
    return;
  }
  if (output.quiet) return;
  if (made.tiles == 0) {
    say("%s: no tile of this result is kept as points; nothing was changed\n", folder.c_str());
    return;
  }
  say("%s: %s tiles have their cells in files now, %s MiB\n", folder.c_str(), std::to_string(made.tiles).c_str(),
      std::to_string((made.bytes >> 20) + 1).c_str());
  if (made.left_as_points > 0) say("%s tiles are kept as points\n", std::to_string(made.left_as_points).c_str());
}

Status run_materialise(Settings& settings, const std::string& folder, const std::vector<std::string>& command_line) {
  if (folder.empty()) return error(Errc::usage, "no result folder is given; try 'tessera materialise --help'");
  BOOST_OUTCOME_TRY(output, output_options(settings));
  if (output.verbose) log_everything();
  MaterialiseOptions options;
  options.command = command_line;
  options.software_version = version();
  options.to = settings.text("output").value_or("");
  BOOST_OUTCOME_TRYV(result::refuse_far(folder));
  if (settings.text("bbox")) {
    BOOST_OUTCOME_TRY(manifest, read_manifest(folder));
    BOOST_OUTCOME_TRY(
        box, settings.get("bbox", [&](const std::string& text) { return parse_crop(text, manifest.dimension); }));
    options.box = box;
  }
  BOOST_OUTCOME_TRY(memory, memory_option(settings));
  options.memory_bytes = memory;
  BOOST_OUTCOME_TRY(threads, threads_option(settings));
  options.threads = threads;
  options.progress = share_line("making cells", output);

  const Interrupt interrupt;
  auto result = materialise(folder, options, interrupt.token());
  clear_line(output);
  BOOST_OUTCOME_TRY(made, std::move(result));
  print(made, output);
  return success();
}

}  // namespace

Command add_materialise(CLI::App& root) {
  auto command = new_command(
      root, "materialise", "Writes the files of cells, for ParaView, of a result that is kept as points",
      "  tessera materialise out/                      (a new version of the result; the files are those that\n"
      "                                                 'triangulate --store cells' writes)\n"
      "  tessera materialise out/ -o cells/            (another folder; out/ stays as it is)\n"
      "  tessera materialise out/ --bbox 0,0,100,100   (only tiles that meet the box)");
  add_value(command, "output", "FOLDER", "write a new result to this folder, and leave the given one as it is", 'o',
            true);
  add_value(command, "bbox", "BOX",
            "xmin,ymin,xmax,ymax or xmin,ymin,zmin,xmax,ymax,zmax: only tiles whose part of space meets it", 0, true);
  add_threads_option(command);
  add_memory_option(command, "tiles");
  add_output_switches(command);
  auto folder = std::make_shared<std::string>();
  add_argument(command, "result", "FOLDER", *folder, "result folder");
  command.run = [settings = command.settings.get(), folder](const std::vector<std::string>& command_line) {
    return run_materialise(*settings, *folder, command_line);
  };
  return command;
}

}  // namespace tessera::apps
