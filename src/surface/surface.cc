#include "src/surface/surface.h"

#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <utility>

#include "src/base/files/surface_names.h"
#include "src/base/json/json_text.h"
#include "src/base/option.h"
#include "src/delaunay/run/run_folder.h"
#include "src/result/tileset/tileset.h"
#include "src/surface/build.h"
#include "src/surface/recipe.h"

namespace tessera {

namespace fs = std::filesystem;

Status check_surface_options(const SurfaceOptions& options) {
  const surface::Energy& energy = options.energy;
  const auto positive = [](double value) { return std::isfinite(value) && value > 0; };
  if (!std::isfinite(energy.lambda) || energy.lambda < 0)
    return error(Errc::usage, option("lambda") + " is not a number of at least 0");
  if (!positive(energy.alpha)) return error(Errc::usage, option("alpha") + " is not a number above 0");
  if (energy.lambda / energy.alpha > 1e4)
    return error(Errc::usage,
                 option("lambda") + " is more than 10,000 times " + option("alpha") + ": no ray would count any more");
  if (!(energy.ray_length > 0)) return error(Errc::usage, option("ray-length") + " is not above 0");
  if (energy.sigma != 0 && !positive(energy.sigma))
    return error(Errc::usage, option("sigma") + " is not a length above 0");
  if (options.output.format == tileset_format && options.output.local)
    return error(Errc::usage, option("format", tileset_format) + " does not take " + option("local"));
  if (options.smooth > smooth_rounds_max)
    return error(Errc::usage, option("smooth") + " is more than " + std::to_string(smooth_rounds_max) + " rounds");
  if (options.trim && !positive(*options.trim)) return error(Errc::usage, option("trim") + " is not a length above 0");
  return success();
}

Result<fs::path> find_surface_target(const fs::path& target, const ExportOptions& options) {
  if (options.format != tileset_format) {
    ExportOptions of_surface = options;
    of_surface.cells_only = true;
    BOOST_OUTCOME_TRY(place, find_export_target(target, of_surface));
    return place.path;
  }
  BOOST_OUTCOME_TRYV(check_tileset_target(target, options.overwrite));
  return target.has_filename() ? target : target.parent_path();
}

namespace {

Result<Exported> write_surface(const fs::path& triangles, const fs::path& target, const SurfaceOptions& options,
                               const Manifest& made_of, std::function<void(double)> progress, std::stop_token stop) {
  if (options.output.format == tileset_format) {
    const TilesetOptions how{.overwrite = options.output.overwrite,
                             .surface_of = made_of.partition,
                             .memory_bytes = options.memory_bytes,
                             .progress = std::move(progress)};
    BOOST_OUTCOME_TRY(written, write_tileset(triangles, target, how, std::move(stop)));
    BOOST_OUTCOME_TRY(manifest, read_manifest(triangles));
    return Exported{
        .path = written.path,
        .vertices = manifest.vertices,
        .cells = written.triangles,
        .bytes = written.bytes,
        .note = std::to_string(written.nodes) + " nodes, of which " + std::to_string(written.leaves) + " are leaves"};
  }
  ExportOptions output = options.output;
  output.longest_edges = true;
  output.comment = surface::recipe_of(options, made_of);
  output.progress = std::move(progress);
  return export_result(triangles, target, output, std::move(stop));
}

}  // namespace

Result<Surface> make_surface(const fs::path& in, const fs::path& target, const SurfaceOptions& asked,
                             surface::StepsRunner& runner, std::stop_token stop) {
  SurfaceOptions options = asked;
  if (options.output.format == tileset_format) options.manifold = true;
  BOOST_OUTCOME_TRYV(check_surface_options(options));
  BOOST_OUTCOME_TRY(place, find_surface_target(target, options.output));
  BOOST_OUTCOME_TRY(source, TileSource::open(in));
  if (options.output.format == tileset_format) {
    BOOST_OUTCOME_TRYV(check_tileset_partition(in, source.manifest().partition));
  }
  BOOST_OUTCOME_TRY(run, RunFolder::claim(surface_run_folder(place), "the surface", options.resume, options.lock));
  constexpr double built_part = 0.9;
  const auto tell = [&](double begin, double end) {
    return [&options, begin, end](double fraction) {
      if (options.progress) options.progress(begin + (end - begin) * fraction);
    };
  };
  const surface::BuildFolder folder{run.path(), run.lock_file(), options.resume};
  BOOST_OUTCOME_TRY(built, surface::build(source, options, folder, false, runner, tell(0, built_part), stop));
  BOOST_OUTCOME_TRY(exported,
                    write_surface(built.triangles, target, options, source.manifest(), tell(built_part, 1), stop));
  run.done();

  Surface made{.mesh = std::move(exported), .digest = built.digest, .sensors = built.sensors};
  made.sigma = built.sigma;
  made.rays = built.rays.rays;
  made.no_rays = built.rays.no_rays;
  made.guessed = built.rays.guessed;
  made.handed_over = built.rays.handed_over;
  made.steps = built.rays.steps;
  made.split = built.split;
  made.cells = source.manifest().cells;
  made.undecided = built.undecided;
  made.outside = built.outside;
  return made;
}

std::string to_json(const Surface& surface, const std::string& output) {
  using Json = nlohmann::ordered_json;
  const Json object{{"event", "surface"},
                    {"output", output},
                    {"vertices", surface.mesh.vertices},
                    {"triangles", surface.mesh.cells},
                    {"bytes", surface.mesh.bytes},
                    {"digest", digest_text(surface.digest)},
                    {"sensors", surface.sensors},
                    {"sigma", surface.sigma},
                    {"rays", surface.rays},
                    {"points_without_ray", surface.no_rays},
                    {"sensors_guessed", surface.guessed},
                    {"rays_handed_over", surface.handed_over},
                    {"ray_steps", surface.steps},
                    {"vertices_added", surface.split},
                    {"cells", surface.cells},
                    {"cells_undecided", surface.undecided},
                    {"cells_outside", surface.outside},
                    {"note", surface.mesh.note}};
  return json_text(object);
}

}  // namespace tessera
