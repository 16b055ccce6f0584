// tessera measure and tessera columns: compute and list the columns of a finished result.
#include "src/result/measure/measure.h"

#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "src/front/apps/command.h"
#include "src/front/apps/interrupt.h"
#include "src/front/apps/log.h"
#include "src/front/apps/machine_options.h"
#include "src/front/apps/outcome.h"
#include "src/front/apps/percent_line.h"
#include "src/front/apps/remote_result.h"
#include "src/front/apps/server_options.h"
#include "src/front/apps/version_option.h"
#include "src/job/describe.h"
#include "src/job/version.h"

namespace tessera::apps {
namespace {

Status run_measure(Settings& settings, const std::string& folder, const std::vector<std::string>& command_line) {
  if (folder.empty()) return error(Errc::usage, "no result folder is given; try 'tessera measure --help'");
  BOOST_OUTCOME_TRY(output, output_options(settings));
  if (output.verbose) log_everything();
  if (names_server(settings)) return measure_remotely(settings, folder, output);
  BOOST_OUTCOME_TRYV(refuse_detach(settings));
  MeasureOptions options{.command = command_line, .software_version = version()};
  BOOST_OUTCOME_TRY(volume, settings.on("volume"));
  options.volume = volume;
  BOOST_OUTCOME_TRY(quality, settings.on("quality"));
  options.quality = quality;
  BOOST_OUTCOME_TRY(voronoi, settings.on("voronoi"));
  options.voronoi = voronoi;
  BOOST_OUTCOME_TRY(density, settings.on("density"));
  options.density = density;
  options.mass = settings.text("mass").value_or("");
  BOOST_OUTCOME_TRY(memory, memory_option(settings));
  options.memory_bytes = memory;
  BOOST_OUTCOME_TRY(threads, threads_option(settings));
  options.threads = threads;
  options.progress = share_line("measuring", output);

  const Interrupt interrupt;
  auto result = measure(folder, options, interrupt.token());
  clear_line(output);
  BOOST_OUTCOME_TRY(measured, std::move(result));
  print_measured(measured, output);
  return success();
}

Status run_columns(Settings& settings, const std::string& folder) {
  if (folder.empty()) return error(Errc::usage, "no result folder is given; try 'tessera columns --help'");
  BOOST_OUTCOME_TRY(output, output_options(settings));
  BOOST_OUTCOME_TRY(version, at_version(settings, folder));
  BOOST_OUTCOME_TRY(text, describe_columns(version, output.json));
  std::fputs(text.c_str(), stdout);
  return success();
}

}  // namespace

Command add_measure(CLI::App& root) {
  auto command = new_command(
      root, "measure",
      "Computes columns of a result: volumes and shapes of cells, Voronoi cells and densities of vertices",
      "  tessera measure out/ --volume                 (columns volume and star_volume; in 2D area, star_area)\n"
      "  tessera measure out/ --quality                (columns radius_ratio, least_angle, largest_angle, "
      "circumradius)\n"
      "  tessera measure out/ --voronoi                (columns voronoi_volume, voronoi_neighbours, ...)\n"
      "  tessera measure out/ --density                (column density: points per unit of volume)\n"
      "  tessera measure out/ --density --mass weight  (column density_weight)\n"
      "  tessera measure out/ --volume --threads 4 --memory 2G\n"
      "  tessera columns out/                          (lists the columns)\n"
      "  tessera measure NAME --volume --server http://127.0.0.1:7070      (a result of a daemon, by the daemon)");
  add_switch(command, "volume",
             "the volume of each cell, and for each vertex the volume of the cells around it; for a 2D result areas", 0,
             true);
  add_switch(command, "quality",
             "the shape of each cell: radius_ratio (1: regular, 0: flat), least_angle and largest_angle in degrees (in "
             "3D between facets), circumradius",
             0, true);
  add_switch(command, "voronoi",
             "the Voronoi cell of each vertex: voronoi_volume and voronoi_surface (2D: voronoi_area, voronoi_boundary; "
             "infinite on the hull), voronoi_neighbours, and the centroid voronoi_x, voronoi_y, voronoi_z",
             0, true);
  add_switch(
      command, "density",
      "the density of each vertex (DTFE): dimension + 1 times its mass, divided by the volume of the cells around "
      "it; each point has the mass 1, duplicates included",
      0, true);
  add_value(command, "mass", "NAME", "the attribute of the vertices that has their masses, for --density", 0, true);
  add_threads_option(command);
  add_memory_option(command, "tiles");
  add_remote_options(command);
  add_output_switches(command);
  auto folder = std::make_shared<std::string>();
  add_argument(command, "result", "FOLDER", *folder, "result folder; with --server, the name of the result");
  command.run = [settings = command.settings.get(), folder](const std::vector<std::string>& command_line) {
    return run_measure(*settings, *folder, command_line);
  };
  return command;
}

Command add_columns(CLI::App& root) {
  auto command =
      new_command(root, "columns", "Lists the columns of a result: what was carried with the points or computed",
                  "  tessera columns out/\n"
                  "  tessera columns out/ --json");
  add_version_option(command);
  add_output_switches(command);
  auto folder = std::make_shared<std::string>();
  add_argument(command, "result", "FOLDER", *folder, "result folder");
  command.run = [settings = command.settings.get(), folder](const std::vector<std::string>&) {
    return run_columns(*settings, *folder);
  };
  return command;
}

}  // namespace tessera::apps
