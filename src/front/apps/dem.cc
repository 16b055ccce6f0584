// tessera dem: writes a 2D result as a raster.
#include "src/result/terrain/dem.h"

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "src/front/apps/command.h"
#include "src/front/apps/drawn.h"
#include "src/front/apps/interrupt.h"
#include "src/front/apps/log.h"
#include "src/front/apps/machine_options.h"
#include "src/front/apps/one_step.h"
#include "src/front/apps/percent_line.h"
#include "src/front/apps/remote_drawing.h"
#include "src/front/apps/server_options.h"
#include "src/job/arguments.h"

namespace tessera::apps {
namespace {

Result<bool> parse_type(const std::string& text) {
  if (text == "float32") return false;
  if (text == "float64") return true;
  return error(Errc::usage, "'" + text + "' is not a type of pixels; the types are float32 and float64");
}

Result<DemMethod> parse_method(const std::string& text) {
  if (const auto method = dem_method_of(text)) return *method;
  return error(Errc::usage, "'" + text + "' is not a method; the methods are linear, natural and laplace");
}

// Returns the light of a hillshade; no value if none is wanted. Error usage for a direction of the light without
// --hillshade.
Result<std::optional<Light>> read_light(Settings& settings) {
  BOOST_OUTCOME_TRY(hillshade, settings.on("hillshade"));
  Light light;
  for (const auto& [key, to] : {std::pair("azimuth", &light.azimuth), std::pair("altitude", &light.altitude)}) {
    BOOST_OUTCOME_TRY(degrees, settings.get(key, [](const std::string& text) { return parse_finite(text); }));
    *to = degrees.value_or(*to);
    if (!hillshade && settings.source(key) == Settings::Source::flag)
      return error(Errc::usage, "--" + std::string(key) + " has no effect without --hillshade");
  }
  return hillshade ? std::optional(light) : std::nullopt;
}

Status run_dem(Settings& settings, const OneStep& made_of) {
  const std::string target = settings.text("output").value_or("");
  if (made_of.sources.empty()) return error(Errc::usage, "no result folder is given; try 'tessera dem --help'");
  if (target.empty()) return error(Errc::usage, "no file to write is given; add -o FILE.tif");
  BOOST_OUTCOME_TRY(output, output_options(settings));
  if (output.verbose) log_everything();
  DemOptions options;
  BOOST_OUTCOME_TRY(res, settings.get("res", [](const std::string& text) { return parse_distance(text); }));
  if (!res) return error(Errc::usage, "the width of a pixel is not given; add --res 0.5");
  options.res = *res;
  BOOST_OUTCOME_TRY(box, settings.get("bbox", [](const std::string& text) { return parse_crop(text, 2); }));
  if (box) options.box = Bounds{box->lo, box->hi};
  BOOST_OUTCOME_TRY(max_edge, settings.get("max-edge", [](const std::string& text) { return parse_distance(text); }));
  options.max_edge = max_edge;
  BOOST_OUTCOME_TRY(radius, settings.get("max-radius", [](const std::string& text) { return parse_distance(text); }));
  options.max_radius = radius;
  options.value = settings.text("value").value_or("z");
  BOOST_OUTCOME_TRY(method, settings.get("method", parse_method));
  options.method = method.value_or(DemMethod::linear);
  BOOST_OUTCOME_TRY(doubles, settings.get("type", parse_type));
  options.doubles = doubles.value_or(false);
  BOOST_OUTCOME_TRY(light, read_light(settings));
  options.light = light;
  BOOST_OUTCOME_TRY(overwrite, settings.on("overwrite"));
  options.overwrite = overwrite;
  BOOST_OUTCOME_TRY(memory, memory_option(settings));
  options.memory_bytes = memory;
  BOOST_OUTCOME_TRY(threads, threads_option(settings));
  options.threads = threads;
  options.progress = share_line("drawing", output);
  if (!names_server(settings)) {
    BOOST_OUTCOME_TRYV(check_dem_target(target, overwrite));
  }
  std::unique_ptr<DemMaker> maker;
  std::optional<Dem> made;
  TileProduct product;
  product.memory_bytes = memory / 4;
  product.make = [&](const Manifest& manifest, const std::stop_token& stop) -> Result<TileConsumer*> {
    DemOptions drawing = options;
    drawing.memory_bytes = product.memory_bytes;
    drawing.threads = threads + 1;  // one of the job's writer threads mostly waits for the disk
    drawing.progress = {};
    BOOST_OUTCOME_TRY(begun, DemMaker::begin(made_of.sources[0], manifest, target, drawing, stop));
    maker = std::move(begun);
    return maker.get();
  };
  product.finish = [&]() -> Status {
    BOOST_OUTCOME_TRY(dem, maker->finish());
    made = std::move(dem);
    return success();
  };
  const auto draw = [&](const std::string& folder) -> Status {
    if (names_server(settings)) return draw_remotely(settings, "dem", folder, target, output);
    BOOST_OUTCOME_TRYV(refuse_detach(settings));
    const Interrupt interrupt;
    auto result = write_dem(folder, target, options, interrupt.token());
    clear_line(output);
    BOOST_OUTCOME_TRY(dem, std::move(result));
    made = std::move(dem);
    return success();
  };
  // Natural neighbours may be in tiles that are not made yet.
  BOOST_OUTCOME_TRYV(options.method == DemMethod::linear ? on_tiles(settings, made_of, output, product, draw)
                                                         : on_result(settings, made_of, output, draw));
  if (made) print_drawn(*made, output);
  return success();
}

}  // namespace

Command add_dem(CLI::App& root) {
  auto command =
      new_command(root, "dem", "Writes the heights of a 2D result as a raster",
                  "  tessera dem ground/ --res 0.5 -o dem.tif                   (a Cloud Optimized GeoTIFF)\n"
                  "  tessera dem ground/ --res 0.5 --max-edge 5 -o dem.tif      (without cells that bridge gaps and "
                  "bays of the hull)\n"
                  "  tessera dem ground/ --res 0.5 --method natural -o dem.tif  (smooth, by natural neighbours)\n"
                  "  tessera dem cloud.laz --res 0.5 --returns first --keep highest -o canopy.tif\n"
                  "  tessera dem ground/ --res 0.5 --bbox 885000,629000,885100,629100 -o part.tif\n"
                  "  tessera dem ground/ --res 1 --value intensity -o intensity.tif\n"
                  "  tessera dem ground/ --res 0.5 --hillshade -o shade.tif");
  add_value(command, "res", "LENGTH", "the width and height of a pixel, in units of the coordinates");
  add_value(command, "bbox", "BOX",
            "xmin,ymin,xmax,ymax: the box that the raster covers; default: the bounds of the result", 0, true);
  add_value(command, "max-edge", "LENGTH",
            "draw no pixels in cells with a longer edge in the plane; default: no limit");
  add_value(command, "max-radius", "LENGTH",
            "draw no pixels in cells with a larger circumradius in the plane; default: no limit");
  add_value(command, "value", "NAME", "the attribute of the vertices to draw; default: z, the heights", 0, true);
  add_value(command, "method", "NAME",
            "how values follow from the vertices: linear in each cell (default), natural (Sibson's natural neighbours, "
            "smooth but for the vertices), or laplace (natural neighbours, with other weights)");
  add_choices(command, "method", "linear, natural, laplace");
  add_value(command, "type", "NAME", "the type of the pixels: float32 (default) or float64");
  add_choices(command, "type", "float32, float64");
  add_switch(command, "hillshade",
             "draw a hillshade of the surface instead of the heights, as 'gdaldem hillshade -compute_edges' makes it "
             "of the raster");
  add_value(command, "azimuth", "DEGREES", "the direction of the light, clockwise from north; default: 315");
  add_value(command, "altitude", "DEGREES", "the height of the light above the horizon; default: 45");
  add_value(command, "output", "PATH", "the file to write, whose name ends in .tif", 'o', true);
  add_memory_option(command, "tiles and pixels");
  add_threads_option(command);
  add_switch(command, "overwrite", "replace a file that exists", 0, true);
  add_remote_options(command);
  add_output_switches(command);
  auto sources = add_sources(command, 2);
  command.run = [settings = command.settings.get(), sources](const std::vector<std::string>& command_line) -> Status {
    return run_dem(*settings, {.sources = *sources,
                               .dimension = 2,
                               .beside = settings->text("output").value_or(""),
                               .command_line = command_line});
  };
  return command;
}

}  // namespace tessera::apps
