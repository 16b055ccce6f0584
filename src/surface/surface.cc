#include "src/surface/surface.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "src/base/option.h"
#include "src/files/surface_names.h"
#include "src/surface/build.h"
#include "src/surface/recipe.h"
#include "src/surface/run_folder.h"

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
  if (options.smooth > smooth_rounds_max)
    return error(Errc::usage, option("smooth") + " is more than " + std::to_string(smooth_rounds_max) + " rounds");
  if (options.trim && !positive(*options.trim)) return error(Errc::usage, option("trim") + " is not a length above 0");
  return success();
}

Result<Surface> make_surface(const fs::path& in, const fs::path& target, const SurfaceOptions& options,
                             surface::StepsRunner& runner, std::stop_token stop) {
  BOOST_OUTCOME_TRYV(check_surface_options(options));
  BOOST_OUTCOME_TRY(place, find_export_target(target, options.output));
  BOOST_OUTCOME_TRY(source, TileSource::open(in));
  BOOST_OUTCOME_TRY(run, surface::RunFolder::claim(surface_run_folder(place.path), options.resume));
  constexpr double built_part = 0.9;
  const auto tell = [&](double begin, double end) {
    return [&options, begin, end](double part) {
      if (options.progress) options.progress(begin + (end - begin) * part);
    };
  };
  const surface::BuildFolder folder{run.path(), run.lock_file(), options.resume};
  BOOST_OUTCOME_TRY(built, surface::build(source, options, folder, false, runner, tell(0, built_part), stop));
  ExportOptions output = options.output;
  output.longest_edges = true;
  output.comment = surface::recipe_of(options, source.manifest());
  output.progress = tell(built_part, 1);
  BOOST_OUTCOME_TRY(exported, export_result(built.triangles, target, output, stop));
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
  return object.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace tessera
