#include "src/surface/build.h"

#include <mutex>
#include <optional>
#include <utility>

#include "src/base/option.h"
#include "src/files/surface_names.h"
#include "src/surface/manifold.h"
#include "src/surface/smooth.h"
#include "src/surface/triangle_store.h"
#include "src/track/estimate.h"
#include "src/track/pulses.h"

namespace tessera::surface {

namespace fs = std::filesystem;

namespace {

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
Status estimate_sensors(const TileSource& source, const SurfaceOptions& options, Sensors& sensors,
                        std::stop_token stop) {
  const auto& schema = source.manifest().schema;
  Pulses all(schema);
  if (!all.missing().empty()) return success();
  std::mutex mutex;
  const TileWork how{options.threads, options.memory_bytes, std::move(stop)};
  BOOST_OUTCOME_TRYV(for_each_tile(source, {.cells = false, .rows = true}, how, [&](auto, auto tile) -> Status {
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

// Of the triangles' folder, once more with what Manifold splits.
Result<Digest> write_split(const fs::path& triangles, const Manifold& manifold, TriangleStore& to,
                           const TileWork& how) {
  BOOST_OUTCOME_TRY(whole, TileSource::open(triangles));
  BOOST_OUTCOME_TRYV(for_each_tile(whole, {.rows = true}, how, [&](std::size_t index, StoredTile tile) {
    const TileId self = whole.entry(index).tile;
    return to.add(self, manifold.apply(std::move(tile), self), how.stop);
  }));
  BOOST_OUTCOME_TRYV(to.finish(whole.manifest().points_read + manifold.new_vertices()));
  return *to.manifest().digest;
}

}  // namespace

Result<Built> build(const TileSource& source, const SurfaceOptions& options, const fs::path& scratch, bool prove,
                    const std::function<void(double)>& progress, const std::stop_token& stop) {
  const Manifest& manifest = source.manifest();
  BOOST_OUTCOME_TRYV(check_result(source.folder(), manifest));
  BOOST_OUTCOME_TRY(sensors, Sensors::make(options.sensors, manifest.schema, manifest.bounds));
  if (sensors.wants_estimate()) {
    BOOST_OUTCOME_TRYV(estimate_sensors(source, options, sensors, stop));
  }
  const double passes_part = options.smooth > 0 ? 0.8 : 1;
  const auto tell = [&](double begin, double end) {
    return [&progress, begin, end](double part) {
      if (progress) progress(begin + (end - begin) * part);
    };
  };
  const auto closed = SurfaceOptions::Bottom::closed, free = SurfaceOptions::Bottom::free;
  BOOST_OUTCOME_TRY(
      passes, Passes::begin(source, sensors, scratch,
                            {.energy = options.energy,
                             .rule = {.lower_inside = options.bottom != free, .unknown_inside = options.unknown_inside},
                             .boundary = {.below = options.bottom == closed, .trim = options.trim},
                             .splits = options.manifold,
                             .prove = prove,
                             .memory_bytes = options.memory_bytes,
                             .threads = options.threads,
                             .progress = tell(0, passes_part),
                             .stop = stop}));
  const TileWork how{options.threads, options.memory_bytes, stop};
  TriangleStore triangles(surface_triangles(scratch), manifest);
  Manifold manifold;
  BOOST_OUTCOME_TRYV(passes->run([&](std::size_t index, const StoredTile& tile, Splits splits) -> Status {
    manifold.add(std::move(splits));
    return triangles.add(source.entry(index).tile, tile, stop);
  }));
  BOOST_OUTCOME_TRYV(triangles.finish(manifest.points_read));
  manifold.settle({manifest.points_read});
  Built built{.triangles = triangles.folder(),
              .digest = *triangles.manifest().digest,
              .split = manifold.new_vertices(),
              .sensors = sensors.used(),
              .passes = {}};
  if (built.split > 0) {
    TriangleStore split(surface_split_triangles(scratch), triangles.manifest());
    BOOST_OUTCOME_TRY(digest, write_split(built.triangles, manifold, split, how));
    built.digest = digest;
    built.triangles = split.folder();
  }
  if (options.smooth > 0) {
    BOOST_OUTCOME_TRY(rough, TileSource::open(built.triangles));
    TriangleStore smoothed(surface_smooth_triangles(scratch), rough.manifest());
    BOOST_OUTCOME_TRYV(smooth(rough, smoothed, surface_smoothing(scratch),
                              {.rounds = options.smooth, .how = how, .progress = tell(passes_part, 1)}));
    BOOST_OUTCOME_TRYV(smoothed.finish(rough.manifest().points_read));
    built.digest = *smoothed.manifest().digest;
    built.triangles = smoothed.folder();
  }
  built.passes = std::move(passes);
  return built;
}

}  // namespace tessera::surface
