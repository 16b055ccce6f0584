// tessera density: puts the density of the points, or a field, on a grid of pixels or voxels.
#include "src/result/density/density.h"

#include <algorithm>
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
#include "src/front/apps/terrain_commands.h"
#include "src/job/arguments.h"

namespace tessera::apps {
namespace {

using density::GridFile;
using density::GridKind;
using density::GridOptions;

// Two numbers more mean a box in 3D.
Result<Bounds> parse_box(const std::string& text) {
  const auto commas = std::count(text.begin(), text.end(), ',');
  BOOST_OUTCOME_TRY(box, parse_crop(text, commas > 3 ? 3 : 2));
  return Bounds{box.lo, box.hi};
}

Status read_names(Settings& settings, GridOptions& options) {
  std::string given;
  for (const auto& [key, kind] : {std::pair("field", GridKind::field), std::pair("divergence", GridKind::divergence),
                                  std::pair("curl", GridKind::curl), std::pair("shear", GridKind::shear)}) {
    BOOST_OUTCOME_TRY(names, settings.get(key, [](const std::string& text) { return parse_names(text); }));
    if (!names) continue;
    if (!given.empty())
      return error(Errc::usage, "--" + given + " and --" + key + " cannot both be on one grid; give one of them");
    given = key;
    options.kind = kind;
    options.names = *names;
  }
  return success();
}

Result<GridOptions> read_options(Settings& settings) {
  GridOptions options;
  BOOST_OUTCOME_TRY(res, settings.get("res", [](const std::string& text) { return parse_distance(text); }));
  BOOST_OUTCOME_TRY(voxels, settings.get("grid", [](const std::string& text) { return parse_grid(text); }));
  if (!res && !voxels)
    return error(Errc::usage,
                 "the width of a pixel or voxel is not given; add --res 0.5, or --grid 256 for as many of them");
  options.shape.res = res.value_or(0);
  options.shape.voxels = voxels.value_or(std::vector<std::int64_t>{});
  BOOST_OUTCOME_TRY(box, settings.get("bbox", parse_box));
  options.shape.box = box;
  BOOST_OUTCOME_TRYV(read_names(settings, options));
  options.mass = settings.text("mass").value_or("");
  BOOST_OUTCOME_TRY(sample, settings.on("sample"));
  options.sample = sample;
  BOOST_OUTCOME_TRY(overwrite, settings.on("overwrite"));
  options.overwrite = overwrite;
  BOOST_OUTCOME_TRY(memory, memory_option(settings));
  options.memory_bytes = memory;
  BOOST_OUTCOME_TRY(threads, threads_option(settings));
  options.threads = threads;
  return options;
}

Status run_density(Settings& settings, const OneStep& made_of) {
  const std::string target = settings.text("output").value_or("");
  if (made_of.sources.empty()) return error(Errc::usage, "no result folder is given; try 'tessera density --help'");
  if (target.empty()) return error(Errc::usage, "no file to write is given; add -o FILE.npy, .h5, .fits or .tif");
  BOOST_OUTCOME_TRY(output, output_options(settings));
  if (output.verbose) log_everything();
  BOOST_OUTCOME_TRY(options, read_options(settings));
  options.progress = share_line("putting cells on the grid", output);
  if (!names_server(settings)) {
    BOOST_OUTCOME_TRYV(density::check_grid_target(target, options.overwrite));
  }
  return on_result(settings, made_of, output, [&](const std::string& folder) -> Status {
    if (names_server(settings)) return draw_remotely(settings, "density", folder, target, output);
    BOOST_OUTCOME_TRYV(refuse_detach(settings));
    const Interrupt interrupt;
    auto result = density::write_grid(folder, target, options, interrupt.token());
    clear_line(output);
    BOOST_OUTCOME_TRY(file, std::move(result));
    print_product(file, output);
    return success();
  });
}

}  // namespace

Command add_density(CLI::App& root) {
  auto command = new_command(
      root, "density", "Puts the density of the points, or a field, on a grid of pixels or voxels",
      "  tessera density galaxy/ --res 4 -o density.npy                      (points per unit of volume, voxel by "
      "voxel)\n"
      "  tessera density cities/ --res 0.5 --mass population -o density.tif  (of a 2D result, as a GeoTIFF)\n"
      "  tessera density gas/ --res 500 --field temperature -o mean.npy      (the mean of an attribute)\n"
      "  tessera density gas/ --res 500 --divergence vx,vy,vz -o div.npy\n"
      "  tessera density box/ --grid 256 --shear vx,vy,vz -o shear.h5        (256 voxels along each axis of a periodic "
      "box)\n"
      "  tessera density 'block/*.laz' --dim 2 --res 1 -o density.tif        (of point files, in one step)");
  add_value(
      command, "res", "LENGTH",
      "the width of a pixel or voxel, in units of the coordinates; along a periodic axis a whole part of the period");
  add_value(command, "grid", "N|NX,NY,NZ",
            "instead of --res, the number of pixels or voxels along each axis, which fill the period, --bbox, or the "
            "bounds of the result",
            0, true);
  add_value(command, "bbox", "BOX",
            "xmin,ymin,xmax,ymax, or in 3D xmin,ymin,zmin,xmax,ymax,zmax: the box that the grid covers; default: the "
            "bounds of the result, along a periodic axis the period",
            0, true);
  add_value(command, "mass", "NAME",
            "the attribute of the vertices that has their masses; default: each point has mass 1", 0, true);
  add_value(command, "field", "NAME", "instead of the density, the mean of this attribute of the vertices", 0, true);
  add_value(command, "divergence", "NAMES",
            "instead of the density, the mean divergence of the vector with these attributes as components: vx,vy,vz",
            0, true);
  add_value(command, "curl", "NAMES",
            "instead of the density, the mean curl of such a vector: in 2D a number, in 3D a vector for each voxel", 0,
            true);
  add_value(command, "shear", "NAMES",
            "instead of the density, the mean shear of such a vector: in 2D xx,xy, in 3D xx,xy,xz,yy,yz for each voxel",
            0, true);
  add_switch(command, "sample", "the values at the centres of pixels or voxels, not the means over them", 0, true);
  add_value(command, "output", "PATH", "the file to write: a .npy, .h5, .fits, or of a 2D result a .tif", 'o', true);
  add_memory_option(command, "tiles and sums");
  add_threads_option(command);
  add_switch(command, "overwrite", "replace a file that exists", 0, true);
  add_remote_options(command);
  add_output_switches(command);
  auto sources = add_sources(command, 0);
  command.run = [settings = command.settings.get(), sources](const std::vector<std::string>& command_line) -> Status {
    return run_density(*settings, {.sources = *sources,
                                   .dimension = 0,
                                   .beside = settings->text("output").value_or(""),
                                   .command_line = command_line,
                                   .carry_all = true});
  };
  return command;
}

}  // namespace tessera::apps
