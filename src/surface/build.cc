#include "src/surface/build.h"

#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <random>
#include <utility>

#include "src/base/files/checksum.h"
#include "src/base/files/folder.h"
#include "src/base/files/names.h"
#include "src/base/files/surface_names.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/base/flat_codec.h"
#include "src/base/option.h"
#include "src/delaunay/run/result_stages.h"
#include "src/exchange/tile_storage.h"
#include "src/result/store/tile_store.h"
#include "src/surface/folder_store.h"
#include "src/surface/kept_codec.h"
#include "src/surface/manifold.h"
#include "src/surface/smooth.h"
#include "src/surface/surface_stages.h"
#include "src/surface/track/estimate.h"
#include "src/surface/track/pulses.h"
#include "src/surface/track/scan_angles.h"
#include "src/surface/triangle_store.h"

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

// Estimates sensors from the points' own pulses and scan angles, if the attributes have them.
Status estimate_sensors(const TileSource& source, const SurfaceOptions& options, Sensors& sensors,
                        std::stop_token stop) {
  const auto& schema = source.manifest().schema;
  Pulses all_pulses(schema);
  ScanAngles all_angles(schema);
  const bool with_pulses = sensors.wants_pulses() && all_pulses.missing().empty(),
             with_angles = sensors.wants_angles() && all_angles.missing().empty();
  if (!with_pulses && !with_angles) return success();
  std::mutex mutex;
  const TileWork how{options.threads, options.memory_bytes, std::move(stop)};
  BOOST_OUTCOME_TRYV(for_each_tile(source, {.cells = false, .rows = true}, how, [&](auto, auto tile) -> Status {
    Pulses pulses(schema);
    ScanAngles angles(schema);
    const std::size_t width = row_bytes(schema);
    for (std::size_t v = 0; v < tile.mesh.points.size(); ++v) {
      if (tile.mesh.point_ghost[v] != 0) continue;
      const std::byte* row = tile.rows.data() + v * width;
      if (with_pulses) pulses.add(tile.mesh.points[v], row);
      if (with_angles) angles.add(tile.mesh.points[v], row);
    }
    const std::lock_guard lock(mutex);
    all_pulses.add(pulses);
    all_angles.add(angles);
    return success();
  }));
  return sensors.use_estimate(estimate_track(all_pulses.take(), all_angles.take()), schema);
}

// Writes the tiles of the triangles' folder again, with the vertices and edges split that Manifold splits.
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

std::string checksum_of_tiles(const Manifest& manifest) {
  FlatWriter all;
  for (const TileEntry& tile : manifest.tiles) {
    all.value(tile.tile.value);
    all.value(tile.own_points);
    all.value(tile.xxh3);
  }
  return checksum_text(checksum(all.take()));
}

SurfacePlan plan_of(const TileSource& source, const SurfaceOptions& options, const Sensors& sensors, bool prove,
                    bool together) {
  const auto closed = SurfaceOptions::Bottom::closed, free = SurfaceOptions::Bottom::free;
  const auto& digest = source.manifest().digest;
  return {.options = {.energy = options.energy,
                      .rule = {.lower_inside = options.bottom != free, .unknown_inside = options.unknown_inside},
                      .boundary = {.below = options.bottom == closed, .trim = options.trim},
                      .splits = options.manifold,
                      .prove = prove,
                      .together = together},
          .sensors = sensors.found(),
          .result = digest ? digest_text(*digest) : "",
          .tiles = checksum_of_tiles(source.manifest()),
          .number = std::uint64_t{std::random_device()()} << 32u | std::random_device()()};
}

// Makes sure that the run has its plan: that of an earlier process, or a new one.
Status begin_run(const BuildFolder& folder, SurfacePlan plan) {
  const fs::path file = plan_file(folder.run);
  if (folder.resume) {
    BOOST_OUTCOME_TRY(there, is_there(file));
    if (there) {
      BOOST_OUTCOME_TRY(bytes, read_whole(file));
      BOOST_OUTCOME_TRY(earlier, read_plan(bytes, file.string()));
      plan.number = earlier.number;
      plan.options.together = earlier.options.together;
      if (to_json(plan) == as_text(bytes)) return success();
      return error(Errc::usage, folder.run.string() + ": cannot be resumed: the unfinished run was started with " +
                                    (plan.result != earlier.result ? "another triangulation"
                                     : plan.tiles != earlier.tiles ? "other tiles"
                                                                   : "other options"));
    }
  }
  return write_whole(file, to_json(plan));
}

// Gathers what tiles have left after the last step.
Status gather(const TileSource& source, const fs::path& run, Built& built, TriangleStore& triangles,
              Manifold& manifold) {
  BOOST_OUTCOME_TRY(plan, read_whole(plan_file(run)));
  const std::uint64_t seal = seal_of_plan(plan);
  const auto kept = [&]<class What>(StepOutput kind, std::size_t i, What what) -> Result<What> {
    const TileId tile = source.entry(i).tile;
    BOOST_OUTCOME_TRY(bytes, read_kept(run, seal, kind, tile));
    if (!read(bytes, what)) return damaged(tile, "state");
    return what;
  };
  for (std::size_t i = 0; i < source.tiles(); ++i) {
    BOOST_OUTCOME_TRY(rays, kept(StepOutput::ray_counts, i, RayCounts()));
    built.rays += rays;
    BOOST_OUTCOME_TRY(sides, kept(StepOutput::arcs, i, KeptSides()));
    built.undecided += sides.undecided;
    BOOST_OUTCOME_TRY(tile, kept(StepOutput::triangles, i, KeptTriangles()));
    built.outside += tile.outside;
    manifold.add(std::move(tile.splits));
    if (tile.entry.empty()) continue;
    const auto entry = tile_entry_of(tile.entry);
    if (!entry) return damaged(source.entry(i).tile, "state");
    triangles.add(*entry);
  }
  BOOST_OUTCOME_TRY(sigma, kept(StepOutput::scales, 0, double()));
  built.sigma = sigma;
  return success();
}

// The stages open the result by its path, perhaps when there is a newer version than that of the source.
fs::path path_of(const TileSource& source) { return version_file(source.folder(), source.manifest().version); }

}  // namespace

Result<Built> build(const TileSource& source, const SurfaceOptions& options, const BuildFolder& folder, bool prove,
                    StepsRunner& runner, const std::function<void(double)>& progress, const std::stop_token& stop) {
  const Manifest& manifest = source.manifest();
  BOOST_OUTCOME_TRYV(check_result(source.folder(), manifest));
  BOOST_OUTCOME_TRY(sensors, Sensors::make(options.sensors, manifest.schema, manifest.bounds));
  if (sensors.wants_angles()) {
    BOOST_OUTCOME_TRYV(estimate_sensors(source, options, sensors, stop));
  }
  const double steps_part = options.smooth > 0 ? 0.8 : 1;
  const auto tell = [&](double begin, double end) {
    return [&progress, begin, end](double fraction) {
      if (progress) progress(begin + (end - begin) * fraction);
    };
  };
  const bool together = source.tiles() > 1 && manifest.cells <= runner.bytes_of_one() / bytes_a_cell;
  BOOST_OUTCOME_TRYV(begin_run(folder, plan_of(source, options, sensors, prove, together)));
  BOOST_OUTCOME_TRYV(runner.run(path_of(source), folder.run, folder.lock_file, tell(0, steps_part), stop));
  Built built{.triangles = surface_triangles(folder.run), .digest = {}, .sensors = sensors.used(), .rays = {}};
  const TileWork how{options.threads, options.memory_bytes, stop};
  TriangleStore triangles(built.triangles, manifest);
  Manifold manifold;
  BOOST_OUTCOME_TRYV(gather(source, folder.run, built, triangles, manifold));
  BOOST_OUTCOME_TRYV(triangles.finish(manifest.points_read));
  built.digest = *triangles.manifest().digest;
  manifold.settle({manifest.points_read});
  built.split = manifold.new_vertices();
  if (built.split > 0) {
    TriangleStore split(surface_split_triangles(folder.run), triangles.manifest());
    BOOST_OUTCOME_TRYV(remove_whole(split.folder()));
    BOOST_OUTCOME_TRY(digest, write_split(built.triangles, manifold, split, how));
    built.digest = digest;
    built.triangles = split.folder();
  }
  if (options.smooth > 0) {
    BOOST_OUTCOME_TRY(rough, TileSource::open(built.triangles));
    TriangleStore smoothed(surface_smooth_triangles(folder.run), rough.manifest());
    BOOST_OUTCOME_TRYV(remove_whole(smoothed.folder()));
    BOOST_OUTCOME_TRYV(remove_whole(surface_smoothing(folder.run)));
    BOOST_OUTCOME_TRYV(smooth(rough, smoothed, surface_smoothing(folder.run),
                              {.rounds = options.smooth, .how = how, .progress = tell(steps_part, 1)}));
    BOOST_OUTCOME_TRYV(smoothed.finish(rough.manifest().points_read));
    built.digest = *smoothed.manifest().digest;
    built.triangles = smoothed.folder();
  }
  return built;
}

}  // namespace tessera::surface
