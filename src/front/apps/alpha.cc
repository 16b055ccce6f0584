// tessera alpha: writes the alpha shape of a result.
#include "src/front/apps/alpha.h"

#include <memory>
#include <optional>
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
#include "src/result/alpha/alpha_shape.h"

namespace tessera::apps {
namespace {

// Nothing stands for auto.
Result<std::optional<double>> parse_radius(const std::string& text) {
  if (text == "auto") return std::optional<double>();
  BOOST_OUTCOME_TRY(radius, parse_distance(text));
  return std::optional(radius);
}

Status run_alpha(Settings& settings, const OneStep& made_of) {
  const std::string target = settings.text("output").value_or("");
  if (made_of.sources.empty()) return error(Errc::usage, "no result folder is given; try 'tessera alpha --help'");
  if (target.empty()) return error(Errc::usage, "no file to write is given; add -o FILE.ply");
  BOOST_OUTCOME_TRY(output, output_options(settings));
  if (output.verbose) log_everything();
  AlphaOptions options;
  BOOST_OUTCOME_TRY(radius, settings.get("alpha", parse_radius));
  if (!radius) return error(Errc::usage, "the radius is not given; add --alpha 5, or --alpha auto");
  options.radius = *radius;
  BOOST_OUTCOME_TRY(general, settings.on("general"));
  options.general = general;
  BOOST_OUTCOME_TRY(overwrite, settings.on("overwrite"));
  options.overwrite = overwrite;
  BOOST_OUTCOME_TRY(memory, memory_option(settings));
  options.memory_bytes = memory;
  BOOST_OUTCOME_TRY(threads, threads_option(settings));
  options.threads = threads;
  options.progress = share_line("making the shape", output);
  return on_result(settings, made_of, output, [&](const std::string& folder) -> Status {
    if (names_server(settings)) return draw_remotely(settings, "alpha", folder, target, output);
    BOOST_OUTCOME_TRYV(refuse_detach(settings));
    const Interrupt interrupt;
    auto result = write_alpha_shape(folder, target, options, interrupt.token());
    clear_line(output);
    BOOST_OUTCOME_TRY(shape, std::move(result));
    print_product(shape, output);
    return success();
  });
}

}  // namespace

Command add_alpha(CLI::App& root) {
  auto command = new_command(
      root, "alpha", "Writes the alpha shape of a result: a concave hull, closed, with holes",
      "  tessera alpha out/ --alpha 2.5 -o mesh.ply           (the boundary of all cells of circumradius up to 2.5)\n"
      "  tessera alpha out/ --alpha auto -o mesh.ply          (the least radius that keeps all points in one piece)\n"
      "  tessera alpha ground/ --alpha 5 -o area.gpkg         (2D: polygons with holes; also .geojson and .fgb)\n"
      "  tessera alpha out/ --alpha 1 --general -o all.ply    (also singular facets, edges and vertices)");
  add_value(command, "alpha", "R",
            "a radius, in units of the coordinates: cells of a circumradius up to R make the shape; or auto: the least "
            "R for which the shape is one piece that has all points");
  add_switch(command, "general",
             "also write singular faces: facets and edges whose smallest sphere has a radius up to R and no vertex "
             "inside, and vertices, that belong to nothing larger in the shape");
  add_value(command, "output", "PATH",
            "the file to write, whose name ends in .ply, or for a 2D result in .gpkg, .geojson or .fgb", 'o', true);
  add_memory_option(command, "tiles and sorting");
  add_threads_option(command);
  add_switch(command, "overwrite", "replace a file that exists", 0, true);
  add_remote_options(command);
  add_output_switches(command);
  auto sources = add_sources(command, 0);
  command.run = [settings = command.settings.get(), sources](const std::vector<std::string>& command_line) -> Status {
    return run_alpha(*settings, {.sources = *sources,
                                 .dimension = 0,
                                 .beside = settings->text("output").value_or(""),
                                 .command_line = command_line});
  };
  return command;
}

}  // namespace tessera::apps
