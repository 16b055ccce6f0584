// tessera contours: writes the contour lines of a 2D result.
#include "src/result/terrain/contours.h"

#include <memory>
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
#include "src/front/apps/terrain_commands.h"
#include "src/job/arguments.h"

namespace tessera::apps {
namespace {

Status run_contours(Settings& settings, const OneStep& made_of) {
  const std::string target = settings.text("output").value_or("");
  if (made_of.sources.empty()) return error(Errc::usage, "no result folder is given; try 'tessera contours --help'");
  if (target.empty()) return error(Errc::usage, "no file to write is given; add -o FILE.gpkg");
  BOOST_OUTCOME_TRY(output, output_options(settings));
  if (output.verbose) log_everything();
  ContourOptions options;
  BOOST_OUTCOME_TRY(interval, settings.get("interval", [](const std::string& text) { return parse_distance(text); }));
  if (!interval) return error(Errc::usage, "the distance between levels is not given; add --interval 5");
  options.interval = *interval;
  BOOST_OUTCOME_TRY(base, settings.get("base", [](const std::string& text) { return parse_finite(text); }));
  options.base = base.value_or(0);
  BOOST_OUTCOME_TRY(box, settings.get("bbox", [](const std::string& text) { return parse_crop(text, 2); }));
  if (box) options.box = Bounds{box->lo, box->hi};
  BOOST_OUTCOME_TRY(max_edge, settings.get("max-edge", [](const std::string& text) { return parse_distance(text); }));
  options.max_edge = max_edge;
  BOOST_OUTCOME_TRY(radius, settings.get("max-radius", [](const std::string& text) { return parse_distance(text); }));
  options.max_radius = radius;
  options.value = settings.text("value").value_or("z");
  BOOST_OUTCOME_TRY(smooth, settings.get("smooth", [](const std::string& text) { return parse_distance(text); }));
  options.smooth = smooth;
  BOOST_OUTCOME_TRY(shortest, settings.get("min-length", [](const std::string& text) { return parse_distance(text); }));
  options.min_length = shortest;
  BOOST_OUTCOME_TRY(every, settings.get("index-every", [](const std::string& text) {
    return parse_integer(text, 1, index_every_max);
  }));
  options.index_every = every.value_or(options.index_every);
  BOOST_OUTCOME_TRY(overwrite, settings.on("overwrite"));
  options.overwrite = overwrite;
  BOOST_OUTCOME_TRY(memory, memory_option(settings));
  options.memory_bytes = memory;
  BOOST_OUTCOME_TRY(threads, threads_option(settings));
  options.threads = threads;
  options.progress = share_line("tracing", output);
  return on_result(settings, made_of, output, [&](const std::string& folder) -> Status {
    if (names_server(settings)) return draw_remotely(settings, "contours", folder, target, output);
    BOOST_OUTCOME_TRYV(refuse_detach(settings));
    const Interrupt interrupt;
    auto result = write_contours(folder, target, options, interrupt.token());
    clear_line(output);
    BOOST_OUTCOME_TRY(contours, std::move(result));
    print_drawn(contours, output);
    return success();
  });
}

}  // namespace

Command add_contours(CLI::App& root) {
  auto command = new_command(
      root, "contours", "Writes the contour lines of a 2D result",
      "  tessera contours ground/ --interval 1 -o lines.gpkg                  (for QGIS, with the attributes "
      "elevation and index)\n"
      "  tessera contours ground/ --interval 1 --smooth 2 --min-length 20 -o map.gpkg    (smooth lines, for maps)\n"
      "  tessera contours ground/ --interval 5 --base 2.5 -o lines.geojson    (levels ..., -2.5, 2.5, 7.5, ...)\n"
      "  tessera contours ground/ --interval 1 --max-edge 5 -o lines.gpkg     (without cells that bridge gaps)\n"
      "  tessera contours ground/ --interval 1 --bbox 885000,629000,885100,629100 -o part.gpkg");
  add_value(command, "interval", "LENGTH", "the distance between levels, in units of the heights");
  add_value(command, "base", "HEIGHT", "the height of one of the levels; default: 0");
  add_value(command, "bbox", "BOX",
            "xmin,ymin,xmax,ymax: draw only lines in cells that meet this box; default: all lines", 0, true);
  add_value(command, "max-edge", "LENGTH", "draw no lines in cells with a longer edge in the plane; default: no limit");
  add_value(command, "max-radius", "LENGTH",
            "draw no lines in cells with a larger circumradius in the plane; default: no limit");
  add_value(command, "value", "NAME", "the attribute of the vertices to draw; default: z, the heights", 0, true);
  add_value(command, "smooth", "LENGTH",
            "draw lines of a smooth surface, the means of the surface in squares of this size; default: lines of the "
            "surface itself");
  add_value(command, "min-length", "LENGTH", "leave out lines that are shorter in the plane; default: keep all lines");
  add_value(command, "index-every", "N", "every N-th level, from --base on, is an index line; default: 5");
  add_value(command, "output", "PATH", "the file to write, whose name ends in .gpkg or .geojson", 'o', true);
  add_memory_option(command, "tiles and lines");
  add_threads_option(command);
  add_switch(command, "overwrite", "replace a file that exists", 0, true);
  add_remote_options(command);
  add_output_switches(command);
  auto sources = add_sources(command, 2);
  command.run = [settings = command.settings.get(), sources](const std::vector<std::string>& command_line) -> Status {
    return run_contours(*settings, {.sources = *sources,
                                    .dimension = 2,
                                    .beside = settings->text("output").value_or(""),
                                    .command_line = command_line});
  };
  return command;
}

}  // namespace tessera::apps
