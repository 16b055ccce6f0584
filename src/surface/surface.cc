#include "src/surface/surface.h"

#include <atomic>
#include <cmath>
#include <mutex>
#include <nlohmann/json.hpp>
#include <numeric>
#include <utility>

#include "src/base/on_threads.h"
#include "src/base/option.h"
#include "src/files/names.h"
#include "src/files/surface_names.h"
#include "src/files/temporary.h"
#include "src/result/tile_queue.h"
#include "src/store/tile_store.h"
#include "src/surface/passes.h"
#include "src/track/estimate.h"
#include "src/track/pulses.h"

namespace tessera {

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
Status estimate_sensors(const TileSource& source, const SurfaceOptions& options, surface::Sensors& sensors,
                        std::stop_token stop) {
  const auto& schema = source.manifest().schema;
  Pulses all(schema);
  if (!all.missing().empty()) return success();
  std::mutex mutex;
  std::vector<std::size_t> tiles(source.tiles());
  std::iota(tiles.begin(), tiles.end(), std::size_t{0});
  TileQueue queue(source, std::move(tiles), std::move(stop), {});
  std::atomic<bool> failed{false};
  const unsigned threads = queue.threads(options.threads, options.memory_bytes, 1, 0);
  BOOST_OUTCOME_TRYV(on_threads(threads, failed, [&]() -> Status {
    while (!failed) {
      BOOST_OUTCOME_TRY(index, queue.next());
      if (!index) break;
      BOOST_OUTCOME_TRY(tile, source.read(*index, {.cells = false, .rows = true}));
      Pulses pulses(schema);
      const std::size_t width = row_bytes(schema);
      for (std::size_t v = 0; v < tile.mesh.points.size(); ++v)
        if (tile.mesh.point_ghost[v] == 0) pulses.add(tile.mesh.points[v], tile.rows.data() + v * width);
      const std::lock_guard lock(mutex);
      all.add(pulses);
    }
    return success();
  }));
  return sensors.use_estimate(estimate_track(all.take()), schema);
}

// What export reads: triangles as a 2D result with heights.
Manifest manifest_of_triangles(const Manifest& from) {
  Manifest manifest = from;
  manifest.version = 1;
  manifest.dimension = 2;
  manifest.neighbors = false;
  manifest.columns.clear();
  manifest.tiles.clear();
  manifest.previous_master_xxh3.reset();
  manifest.partition_kind = "random";  // no box of a tile says where its triangles are
  manifest.partition =
      nlohmann::json{
          {"kind", "random"}, {"dimension", 2}, {"tiles", manifest.boxes.size()}, {"splits", nlohmann::json::array()}}
          .dump();
  manifest.duplicates = manifest.duplicates_xxh3 = 0;
  manifest.vertices = manifest.cells = 0;
  manifest.other_heights.reset();
  manifest.schema.insert(manifest.schema.begin(), Attribute{"z", AttributeType::f64});
  return manifest;
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

  constexpr double passes_part = 0.9;
  const auto closed = SurfaceOptions::Bottom::closed, free = SurfaceOptions::Bottom::free;
  BOOST_OUTCOME_TRY(passes,
                    surface::Passes::begin(
                        source, sensors, scratch.path(),
                        {.energy = options.energy,
                         .rule = {.lower_inside = options.bottom != free, .unknown_inside = options.unknown_inside},
                         .boundary = {.below = options.bottom == closed, .trim = options.trim},
                         .memory_bytes = options.memory_bytes,
                         .threads = options.threads,
                         .progress =
                             [&](double part) {
                               if (options.progress) options.progress(passes_part * part);
                             },
                         .stop = stop}));
  const fs::path triangles = surface_triangles(scratch.path());
  Manifest manifest = manifest_of_triangles(source.manifest());
  std::mutex mutex;
  BOOST_OUTCOME_TRYV(passes->run([&](std::size_t index, const StoredTile& tile) -> Status {
    if (tile.mesh.cells.empty()) return success();
    BOOST_OUTCOME_TRY(entry, write_tile(triangles, source.entry(index).tile, tile.mesh, tile.rows,
                                        {.neighbors = false, .schema = tile.schema, .stop = stop}));
    const std::lock_guard lock(mutex);
    manifest.vertices += entry.own_points;
    manifest.cells += entry.main_cells;
    manifest.tiles.push_back(std::move(entry));
    return success();
  }));
  if (manifest.cells == 0) return error(Errc::usage, "there is no surface: all cells are on one side of it");
  BOOST_OUTCOME_TRYV(finish_store(triangles, manifest, std::span<const DuplicatePair>()));
  ExportOptions output = options.output;
  output.progress = [&](double part) {
    if (options.progress) options.progress(passes_part + (1 - passes_part) * part);
  };
  BOOST_OUTCOME_TRY(exported, export_result(triangles, target, output, stop));

  const surface::Counts& counts = passes->counts();
  Surface made{.mesh = std::move(exported), .digest = *manifest.digest, .sensors = sensors.used()};
  made.sigma = counts.sigma;
  made.rays = counts.rays;
  made.no_rays = counts.no_rays;
  made.guessed = counts.guessed;
  made.handed_over = counts.handed_over;
  made.steps = counts.steps;
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
                    {"cells", surface.cells},
                    {"cells_undecided", surface.undecided},
                    {"cells_outside", surface.outside},
                    {"note", surface.mesh.note}};
  return object.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace tessera
