// tessera voronoi: writes the Voronoi cells of the points of a result.
#include "src/result/voronoi/voronoi.h"

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
#include "src/front/apps/products.h"
#include "src/front/apps/remote_drawing.h"
#include "src/front/apps/server_options.h"
#include "src/job/arguments.h"

namespace tessera::apps {
namespace {

// hull, none, a box of four or six numbers, or else the name of a file.
Status read_clip(const std::string& text, VoronoiOptions& options) {
  if (text == "hull" || text == "none") {
    options.clip = text == "hull" ? VoronoiClip::hull : VoronoiClip::none;
    return success();
  }
  if (text.find(',') == std::string::npos || text.find_first_not_of("0123456789+-.,eE ") != std::string::npos) {
    options.clip = VoronoiClip::file;
    options.polygons = text;
    return success();
  }
  BOOST_OUTCOME_TRY(box, parse_crop(text, 3));
  options.clip = VoronoiClip::box;
  options.box = Bounds{box.lo, box.hi};
  return success();
}

Status run_voronoi(Settings& settings, const OneStep& made_of) {
  const std::string target = settings.text("output").value_or("");
  if (made_of.sources.empty()) return error(Errc::usage, "no result folder is given; try 'tessera voronoi --help'");
  if (target.empty()) return error(Errc::usage, "no file to write is given; add -o FILE.gpkg");
  BOOST_OUTCOME_TRY(output, output_options(settings));
  if (output.verbose) log_everything();
  VoronoiOptions options;
  if (const auto clip = settings.text("clip")) {
    const auto read = read_clip(*clip, options);
    if (!read) return error(Errc::usage, "--clip: " + read.error().where);
  }
  BOOST_OUTCOME_TRY(overwrite, settings.on("overwrite"));
  options.overwrite = overwrite;
  BOOST_OUTCOME_TRY(memory, memory_option(settings));
  options.memory_bytes = memory;
  BOOST_OUTCOME_TRY(threads, threads_option(settings));
  options.threads = threads;
  options.progress = share_line("making cells", output);
  return on_result(settings, made_of, output, [&](const std::string& folder) -> Status {
    if (names_server(settings)) {
      RemoteTexts texts;
      if (options.clip == VoronoiClip::file) {
        BOOST_OUTCOME_TRY(text, polygons_for_daemon("clip", options.polygons));
        texts["clip"] = std::move(text);
      }
      return draw_remotely(settings, "voronoi", folder, target, output, texts);
    }
    BOOST_OUTCOME_TRYV(refuse_detach(settings));
    const Interrupt interrupt;
    auto result = write_voronoi(folder, target, options, interrupt.token());
    clear_line(output);
    BOOST_OUTCOME_TRY(written, std::move(result));
    print_product(written, output);
    return success();
  });
}

}  // namespace

Command add_voronoi(CLI::App& root) {
  auto command = new_command(
      root, "voronoi", "Writes the Voronoi cells of points, as polygons or polyhedra",
      "  tessera voronoi stations/ -o cells.gpkg                              (2D: polygons within the convex hull)\n"
      "  tessera voronoi stations.csv -o cells.gpkg --clip country.gpkg       (a point file in one step)\n"
      "  tessera voronoi stations/ -o cells.geojson --clip 0,0,1000,800\n"
      "  tessera voronoi stations/ -o cells.csv --clip none                   (unbounded cells have no polygon)\n"
      "  tessera voronoi grains/ -o cells.vtu --clip 0,0,0,10,10,10           (3D: polyhedra, for ParaView)");
  add_value(command, "output", "PATH",
            "the file to write: .gpkg, .fgb, .geojson or .csv for a 2D result, .vtu for a 3D one", 'o', true);
  add_value(
      command, "clip", "CLIP",
      "clip cells to hull (the convex hull; default in 2D), to a box xmin,ymin,xmax,ymax (3D: "
      "xmin,ymin,zmin,xmax,ymax,zmax), or to the polygons of a file (.gpkg, .fgb, .geojson); none: leave them whole "
      "(default in 3D)",
      0, true);
  add_threads_option(command);
  add_memory_option(command, "tiles");
  add_switch(command, "overwrite", "replace a file that exists", 0, true);
  add_remote_options(command);
  add_output_switches(command);
  auto sources = add_sources(command, 0);
  command.run = [settings = command.settings.get(), sources](const std::vector<std::string>& command_line) -> Status {
    return run_voronoi(*settings, {.sources = *sources,
                                   .dimension = 0,
                                   .beside = settings->text("output").value_or(""),
                                   .command_line = command_line});
  };
  return command;
}

}  // namespace tessera::apps
