// tessera voids: finds the watershed voids of the density of a result.
#include "src/result/voids/voids.h"

#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "src/front/apps/command.h"
#include "src/front/apps/interrupt.h"
#include "src/front/apps/log.h"
#include "src/front/apps/machine_options.h"
#include "src/front/apps/percent_line.h"
#include "src/front/apps/say.h"
#include "src/job/report/human.h"
#include "src/job/version.h"

namespace tessera::apps {
namespace {

void print_voids(const voids::Found& found, const OutputOptions& output) {
  if (output.json) {
    std::printf("%s\n", to_json(found).c_str());
    return;
  }
  if (output.quiet) return;
  say("%s: %s in %s\n", found.folder.c_str(), counted(found.points, "point").c_str(),
      counted(found.zones, "zone").c_str());
  if (found.outside > 0)
    say("%s with unbounded Voronoi cells, on the hull, are in no zone\n", counted(found.outside, "point").c_str());
  if (found.made) {
    say("version %u has the column %s of vertices\n", found.version, found.column.c_str());
  } else {
    say("the result has the column %s already, and was not changed\n", found.column.c_str());
  }
  for (const auto& file : found.files) say("%s: written\n", file.c_str());
}

Status run_voids(Settings& settings, const std::string& folder, const std::vector<std::string>& command_line) {
  if (folder.empty()) return error(Errc::usage, "no result folder is given; try 'tessera voids --help'");
  BOOST_OUTCOME_TRY(output, output_options(settings));
  if (output.verbose) log_everything();
  voids::VoidsOptions options{.command = command_line, .software_version = version()};
  options.by = settings.text("by").value_or(options.by);
  options.target = settings.text("output").value_or("");
  BOOST_OUTCOME_TRY(overwrite, settings.on("overwrite"));
  options.overwrite = overwrite;
  BOOST_OUTCOME_TRY(memory, memory_option(settings));
  options.memory_bytes = memory;
  BOOST_OUTCOME_TRY(threads, threads_option(settings));
  options.threads = threads;
  options.progress = share_line("looking for voids", output);

  const Interrupt interrupt;
  auto result = voids::find_voids(folder, options, interrupt.token());
  clear_line(output);
  BOOST_OUTCOME_TRY(voids, std::move(result));
  print_voids(voids.found, output);
  return success();
}

}  // namespace

Command add_voids(CLI::App& root) {
  auto command = new_command(
      root, "voids", "Finds voids: zones that the density flows into, their saddles and hierarchy, as ZOBOV does",
      "  tessera voids out/                             (the column zone: of each vertex, the core of its zone)\n"
      "  tessera voids out/ -o voids.csv                (and a table of the voids)\n"
      "  tessera voids out/ -o voids.txt                (and voids.txt, voids.zone, voids.void, as ZOBOV writes them)\n"
      "  tessera voids out/ --by density -o voids.csv   (of the density of the Delaunay cells, DTFE)");
  add_value(command, "by", "DENSITY",
            "the density of a vertex: voronoi, 1 over the volume of its Voronoi cell; density, the column of measure "
            "--density; or density_NAME, with the attribute NAME as masses; columns that are missing are computed; "
            "default: voronoi",
            0, true);
  add_value(
      command, "output", "PATH",
      "a file to write: a .csv, a table of the voids; or a .txt, which writes .txt, .zone and .void as ZOBOV does", 'o',
      true);
  add_memory_option(command, "tiles");
  add_threads_option(command);
  add_switch(command, "overwrite", "replace files that exist", 0, true);
  add_output_switches(command);
  auto folder = std::make_shared<std::string>();
  add_argument(command, "result", "FOLDER", *folder, "result folder");
  command.run = [settings = command.settings.get(), folder](const std::vector<std::string>& command_line) {
    return run_voids(*settings, *folder, command_line);
  };
  return command;
}

}  // namespace tessera::apps
