#include "src/surface/surface.h"

#include <cmath>
#include <mutex>
#include <nlohmann/json.hpp>
#include <utility>

#include "src/base/option.h"
#include "src/files/names.h"
#include "src/files/surface_names.h"
#include "src/files/temporary.h"
#include "src/surface/manifold.h"
#include "src/surface/passes.h"
#include "src/surface/smooth.h"
#include "src/surface/triangle_store.h"
#include "src/track/estimate.h"
#include "src/track/pulses.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

constexpr unsigned smooth_max = 1000;

Status check_result(const fs::path& in, const Manifest& manifest) {
  if (manifest.dimension != 3)
    return error(Errc::usage, in.string() +
                                  ": is a 2D triangulation, which is a surface already; surfaces are made "
                                  "of 3D ones (" +
                                  option("dim", "3") + ")");
  if (!manifest.neighbors)
    return error(Errc::usage, in.string() + ": was stored without neighbours, by which rays go from cell to cell");
  if (manifest.region)
    return error(Errc::usage, in.string() +
                                  ": is the region of a cloud: where a surface runs in it depends on cells "
                                  "that are not there");
  return success();
}

// From the points' own pulses, if their attributes tell of such.
Status estimate_sensors(const TileSource& source, const SurfaceOptions& options, surface::Sensors& sensors,
                        std::stop_token stop) {
  const auto& schema = source.manifest().schema;
  Pulses all(schema);
  if (!all.missing().empty()) return success();
  std::mutex mutex;
  const surface::TileWork how{options.threads, options.memory_bytes, std::move(stop)};
  BOOST_OUTCOME_TRYV(
      surface::for_each_tile(source, {.cells = false, .rows = true}, how, [&](auto, auto tile) -> Status {
        Pulses pulses(schema);
        const std::size_t width = row_bytes(schema);
        for (std::size_t v = 0; v < tile.mesh.points.size(); ++v)
          if (tile.mesh.point_ghost[v] == 0) pulses.add(tile.mesh.points[v], tile.rows.data() + v * width);
        const std::lock_guard lock(mutex);
        all.add(pulses);
        return success();
      }));
  return sensors.use_estimate(estimate_track(all.take()), schema);
}

}  // namespace

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
  if (options.smooth > smooth_max)
    return error(Errc::usage, option("smooth") + " is more than " + std::to_string(smooth_max) + " rounds");
  if (options.trim && !positive(*options.trim)) return error(Errc::usage, option("trim") + " is not a length above 0");
  return success();
}

Result<Surface> make_surface(const fs::path& in, const fs::path& target, const SurfaceOptions& options,
                             std::stop_token stop) {
  BOOST_OUTCOME_TRYV(check_surface_options(options));
  BOOST_OUTCOME_TRY(place, find_export_target(target, options.output));
  BOOST_OUTCOME_TRY(source, TileSource::open(in));
  BOOST_OUTCOME_TRYV(check_result(in, source.manifest()));
  BOOST_OUTCOME_TRY(sensors,
                    surface::Sensors::make(options.sensors, source.manifest().schema, source.manifest().bounds));
  if (sensors.wants_estimate()) {
    BOOST_OUTCOME_TRYV(estimate_sensors(source, options, sensors, stop));
  }
  BOOST_OUTCOME_TRY(scratch, TemporaryFolder::make(temporary_name_of_process(place.path.string() + ".surface")));

  // How far all is when each part is done.
  const bool smooths = options.smooth > 0;
  const double cells_done = smooths ? 0.7 : 0.9, smooth_done = 0.9;
  const auto tell = [&](double begin, double end) {
    return [&options, begin, end](double part) {
      if (options.progress) options.progress(begin + (end - begin) * part);
    };
  };
  const auto closed = SurfaceOptions::Bottom::closed, free = SurfaceOptions::Bottom::free;
  BOOST_OUTCOME_TRY(passes,
                    surface::Passes::begin(
                        source, sensors, scratch.path(),
                        {.energy = options.energy,
                         .rule = {.lower_inside = options.bottom != free, .unknown_inside = options.unknown_inside},
                         .boundary = {.below = options.bottom == closed, .trim = options.trim},
                         .splits = options.manifold,
                         .memory_bytes = options.memory_bytes,
                         .threads = options.threads,
                         .progress = tell(0, cells_done),
                         .stop = stop}));
  surface::TriangleStore triangles(surface_triangles(scratch.path()), source.manifest());
  surface::Manifold manifold;
  BOOST_OUTCOME_TRYV(passes->run([&](std::size_t index, const StoredTile& tile, surface::Splits splits) -> Status {
    manifold.add(std::move(splits));
    return triangles.add(source.entry(index).tile, tile, stop);
  }));
  const std::uint64_t ids = source.manifest().points_read;
  BOOST_OUTCOME_TRYV(triangles.finish(ids));
  fs::path finished = triangles.folder();
  Digest digest = *triangles.manifest().digest;
  const surface::TileWork how{options.threads, options.memory_bytes, stop};
  manifold.settle({ids});
  if (manifold.new_vertices() > 0) {
    BOOST_OUTCOME_TRY(whole, TileSource::open(finished));
    surface::TriangleStore split(surface_split_triangles(scratch.path()), whole.manifest());
    BOOST_OUTCOME_TRYV(surface::for_each_tile(whole, {.rows = true}, how, [&](std::size_t index, StoredTile tile) {
      const TileId self = whole.entry(index).tile;
      return split.add(self, manifold.apply(std::move(tile), self), stop);
    }));
    BOOST_OUTCOME_TRYV(split.finish(ids + manifold.new_vertices()));
    finished = split.folder();
    digest = *split.manifest().digest;
  }
  if (smooths) {
    BOOST_OUTCOME_TRY(rough, TileSource::open(finished));
    surface::TriangleStore smoothed(surface_smooth_triangles(scratch.path()), rough.manifest());
    BOOST_OUTCOME_TRYV(
        surface::smooth(rough, smoothed, surface_smoothing(scratch.path()),
                        {.rounds = options.smooth, .how = how, .progress = tell(cells_done, smooth_done)}));
    BOOST_OUTCOME_TRYV(smoothed.finish(rough.manifest().points_read));
    finished = smoothed.folder();
    digest = *smoothed.manifest().digest;
  }
  ExportOptions output = options.output;
  output.longest_edges = true;
  output.progress = tell(smooths ? smooth_done : cells_done, 1);
  BOOST_OUTCOME_TRY(exported, export_result(finished, target, output, stop));

  const surface::Counts& counts = passes->counts();
  Surface made{.mesh = std::move(exported), .digest = digest, .sensors = sensors.used()};
  made.sigma = counts.sigma;
  made.rays = counts.rays;
  made.no_rays = counts.no_rays;
  made.guessed = counts.guessed;
  made.handed_over = counts.handed_over;
  made.steps = counts.steps;
  made.split = manifold.new_vertices();
  made.cells = source.manifest().cells;
  made.undecided = counts.undecided;
  made.outside = counts.outside;
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
