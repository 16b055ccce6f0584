// tessera volume: cut and fill between two surfaces.
#include <cstdio>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "src/base/printable.h"
#include "src/front/apps/command.h"
#include "src/front/apps/drawn.h"
#include "src/front/apps/interrupt.h"
#include "src/front/apps/log.h"
#include "src/front/apps/machine_options.h"
#include "src/front/apps/one_step.h"
#include "src/front/apps/percent_line.h"
#include "src/front/apps/products.h"
#include "src/front/apps/remote_drawing.h"
#include "src/front/apps/remote_inputs.h"
#include "src/front/apps/server_options.h"
#include "src/front/apps/triangulate_options.h"
#include "src/front/apps/version_option.h"
#include "src/job/arguments.h"
#include "src/result/volume/difference.h"
#include "src/result/volume/volume_table.h"
#include "src/result/volume/volumes.h"

namespace tessera::apps {
namespace {

struct VolumeRequest {
  std::string a, b;                // results or point files
  std::string target, difference;  // files to write; may be empty
  double res = 0;                  // of the difference
  bool overwrite = false;
  VolumeOptions options;
  OutputOptions output;
};

Result<VolumeRequest> read_request(Settings& settings, const std::string& a, const std::string& b) {
  VolumeRequest request{.a = a, .b = b, .target = {}, .difference = {}, .options = {}, .output = {}};
  if (a.empty()) return error(Errc::usage, "no surface is given; try 'tessera volume --help'");
  BOOST_OUTCOME_TRY(output, output_options(settings));
  request.output = output;
  VolumeOptions& options = request.options;
  BOOST_OUTCOME_TRY(plane, settings.get("plane", [](const std::string& text) { return parse_finite(text); }));
  options.plane = plane;
  options.base = settings.text("base").value_or("");
  options.within = settings.text("within").value_or("");
  options.name = settings.text("name").value_or("");
  BOOST_OUTCOME_TRY(max_edge, settings.get("max-edge", [](const std::string& text) { return parse_distance(text); }));
  options.max_edge = max_edge;
  BOOST_OUTCOME_TRY(radius, settings.get("max-radius", [](const std::string& text) { return parse_distance(text); }));
  options.max_radius = radius;
  options.value = settings.text("value").value_or("z");
  BOOST_OUTCOME_TRYV(check_volume_options(!b.empty(), options));
  BOOST_OUTCOME_TRY(overwrite, settings.on("overwrite"));
  request.overwrite = overwrite;
  request.target = settings.text("output").value_or("");
  if (!request.target.empty() && !names_server(settings)) {
    const bool polygons = !options.base.empty() || !options.within.empty();
    BOOST_OUTCOME_TRYV(check_volumes_target(request.target, polygons, overwrite));
  }
  request.difference = settings.text("difference").value_or("");
  BOOST_OUTCOME_TRY(res, settings.get("res", [](const std::string& text) { return parse_distance(text); }));
  request.res = res.value_or(0);
  if (request.difference.empty() && settings.source("res") == Settings::Source::flag)
    return error(Errc::usage, "--res has no effect without --difference FILE.tif");
  if (!request.difference.empty()) {
    if (!res) return error(Errc::usage, "the width of a pixel of --difference is not given; add --res 0.5");
    BOOST_OUTCOME_TRYV(check_dem_target(request.difference, overwrite));
  }
  BOOST_OUTCOME_TRY(memory, memory_option(settings));
  options.memory_bytes = memory;
  BOOST_OUTCOME_TRY(threads, threads_option(settings));
  options.threads = threads;
  return request;
}

// Without a file for it, the table goes to standard output.
Status print(const VolumeRequest& request, const Volumes& made) {
  if (request.output.json) {
    std::printf("%s\n", to_json(made, request.target).c_str());
    return success();
  }
  if (request.target.empty()) {
    const std::string text = printable_lines(to_text(made));
    if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() || std::fflush(stdout) != 0)
      return error(Errc::io, "standard output: cannot be written");
  }
  print_product(request.target, made, request.output);
  return success();
}

Status compute(VolumeRequest& request, const std::string& a, const std::optional<std::string>& b) {
  const Interrupt interrupt;
  std::optional<std::filesystem::path> second;
  if (b) second = *b;
  request.options.progress = share_line("computing volumes", request.output);
  auto result = volumes(a, second, request.options, interrupt.token());
  clear_line(request.output);
  BOOST_OUTCOME_TRY(made, std::move(result));
  if (!request.difference.empty()) {
    request.options.progress = share_line("drawing", request.output);
    auto drawn = write_difference(a, second, request.difference, request.res, request.overwrite, request.options,
                                  interrupt.token());
    clear_line(request.output);
    BOOST_OUTCOME_TRY(raster, std::move(drawn));
    print_drawn(raster, request.output);
  }
  if (!request.target.empty()) {
    BOOST_OUTCOME_TRYV(write_volumes(made, request.target));
  }
  return print(request, made);
}

// Cut and fill from one result of a daemon to another.
Status volume_remotely(Settings& settings, const VolumeRequest& request) {
  if (request.target.empty())
    return error(Errc::usage, "a daemon writes the volumes as a table; add -o FILE.csv, -o FILE.json or -o FILE.gpkg");
  RemoteTexts texts;
  for (const auto& [key, file] :
       {std::pair("base", request.options.base), std::pair("within", request.options.within)}) {
    if (file.empty()) continue;
    BOOST_OUTCOME_TRY(text, polygons_for_daemon(key, file));
    texts[key] = std::move(text);
  }
  if (!request.b.empty()) texts["second"] = without_slash(request.b);
  return draw_remotely(settings, "volume", request.a, request.target, request.output, texts);
}

Status run_volume(Settings& settings, const std::string& a, const std::string& b,
                  const std::vector<std::string>& command_line) {
  BOOST_OUTCOME_TRY(request, read_request(settings, a, b));
  if (request.output.verbose) log_everything();
  if (!b.empty() && settings.text("version"))
    return error(Errc::usage, "--version is for one result; name a version of two by its manifest, for example " + a +
                                  "/.versions/000001.json");
  if (settings.text("version") && names_server(settings)) {
    BOOST_OUTCOME_TRYV(at_version(settings, a));
  }
  if (names_server(settings)) return volume_remotely(settings, request);
  BOOST_OUTCOME_TRYV(refuse_detach(settings));
  const std::string& beside = request.target.empty() ? request.difference : request.target;
  const auto made_of = [&](const std::string& source, const char* which) {
    return OneStep{.sources = {source},
                   .dimension = 2,
                   .beside = (beside.empty() ? std::string("tessera") : beside) + which,
                   .command_line = command_line};
  };
  return on_result(settings, made_of(a, ".a"), request.output, [&](const std::string& first) -> Status {
    if (b.empty()) return compute(request, first, std::nullopt);
    return on_result(settings, made_of(b, ".b"), request.output,
                     [&](const std::string& second) { return compute(request, first, second); });
  });
}

}  // namespace

Command add_volume(CLI::App& root) {
  auto command = new_command(
      root, "volume", "Computes volumes between two surfaces: cut, fill, and what is not covered",
      "  tessera volume before/ after/                                     (two 2D results; cut: where after/ is "
      "lower)\n"
      "  tessera volume 2023.laz 2024.laz --class 2 --max-edge 5           (point files, in one step)\n"
      "  tessera volume ground/ --plane 120                                (above the level 120: cut; below: fill)\n"
      "  tessera volume scan/ --base piles.gpkg --name pile -o piles.csv   (stockpiles over their rims)\n"
      "  tessera volume before/ after/ --within fields.geojson -o volumes.gpkg\n"
      "  tessera volume before/ after/ --difference change.tif --res 0.5\n\n"
      "A is the surface before, B the surface after. Cut is the volume where A lies above B: material to take away to\n"
      "come from A to B. Fill is the volume where B lies above A: material to add. Net is cut - fill. Volumes are "
      "those\n"
      "over the area that both surfaces cover; what one of them does not cover is listed as area.");
  add_value(command, "plane", "Z", "B is the level plane at this height", 0, true);
  add_value(command, "base", "FILE",
            "B is spanned by the vertices of polygons, which have heights; each polygon is a row (GeoPackage, GeoJSON, "
            "FlatGeobuf, Shapefile)",
            0, true);
  add_value(command, "within", "FILE", "a row for each polygon of this file: the volumes inside of the polygon", 0,
            true);
  add_value(command, "name", "NAME", "the attribute that names the polygons; default: name or id, if there is one", 0,
            true);
  add_value(command, "max-edge", "LENGTH",
            "leave out cells with a longer edge in the plane, which are holes then; default: no limit");
  add_value(command, "max-radius", "LENGTH",
            "leave out cells with a larger circumradius in the plane, too; default: no limit");
  add_value(command, "value", "NAME", "the attribute of the vertices that has the heights; default: z", 0, true);
  add_value(command, "output", "PATH", "the table to write: .csv, .json or .gpkg; without it, standard output", 'o',
            true);
  add_value(command, "difference", "FILE", "also write a raster of A - B, whose name ends in .tif", 0, true);
  add_value(command, "res", "LENGTH", "the width and height of a pixel of the raster, in units of the coordinates");
  add_threads_option(command);
  add_memory_option(command, "tiles and polygons");
  add_switch(command, "overwrite", "replace files that exist", 0, true);
  add_remote_options(command);
  add_source_options(command);
  add_output_switches(command);
  auto a = std::make_shared<std::string>(), b = std::make_shared<std::string>();
  add_version_option(command);
  add_argument(command, "before", "A", *a, "the surface A: a result folder, or a point file or pattern");
  add_argument(command, "after", "B", *b, "the surface B, likewise; not with --plane or --base");
  command.run = [settings = command.settings.get(), a, b](const std::vector<std::string>& command_line) -> Status {
    return run_volume(*settings, *a, *b, command_line);
  };
  return command;
}

}  // namespace tessera::apps
