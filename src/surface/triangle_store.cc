#include "src/surface/triangle_store.h"

#include <atomic>
#include <nlohmann/json.hpp>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "src/base/json/json_text.h"
#include "src/base/on_threads.h"
#include "src/result/tile_queue.h"

namespace tessera::surface {

namespace {

Manifest manifest_of_triangles(const Manifest& from) {
  Manifest manifest = from;
  manifest.version = 1;
  manifest.tiles.clear();
  manifest.previous_master_xxh3.reset();
  manifest.vertices = manifest.cells = 0;
  manifest.digest.reset();
  if (from.dimension == 2) return manifest;
  manifest.dimension = 2;
  manifest.neighbors = false;
  manifest.columns.clear();
  manifest.partition_kind = "random";  // the box of a tile does not say where its triangles are
  manifest.partition = json_text(nlohmann::json{
      {"kind", "random"}, {"dimension", 2}, {"tiles", manifest.boxes.size()}, {"splits", nlohmann::json::array()}});
  manifest.duplicates = manifest.duplicates_xxh3 = 0;
  manifest.other_heights.reset();
  manifest.schema.insert(manifest.schema.begin(), Attribute{"z", AttributeType::f64});
  return manifest;
}

}  // namespace

TriangleStore::TriangleStore(std::filesystem::path folder, const Manifest& from)
    : folder_(std::move(folder)), manifest_(manifest_of_triangles(from)) {}

Status TriangleStore::add(TileId tile, const StoredTile& triangles, const std::stop_token& stop) {
  if (triangles.mesh.cells.empty()) return success();
  BOOST_OUTCOME_TRY(entry, write_tile(folder_, tile, triangles.mesh, triangles.rows,
                                      {.neighbors = false, .schema = triangles.schema, .stop = stop}));
  add(std::move(entry));
  return success();
}

void TriangleStore::add(TileEntry entry) {
  const std::lock_guard lock(mutex_);
  manifest_.vertices += entry.own_points;
  manifest_.cells += entry.main_cells;
  manifest_.tiles.push_back(std::move(entry));
}

Status TriangleStore::finish(std::uint64_t ids) {
  if (manifest_.cells == 0) return error(Errc::usage, "there is no surface: all cells are on one side of it");
  manifest_.points_read = ids;
  return finish_store(folder_, manifest_, std::span<const DuplicatePair>());
}

Status for_each_tile(const TileSource& source, const TileFields& parts, const TileWork& how,
                     const std::function<Status(std::size_t index, StoredTile tile)>& work) {
  std::vector<std::size_t> tiles(source.tiles());
  std::iota(tiles.begin(), tiles.end(), std::size_t{0});
  TileQueue queue(source, std::move(tiles), how.stop, {});
  std::atomic<bool> failed{false};
  return on_threads(queue.threads(how.threads, how.memory_bytes, 1, 0), failed, [&]() -> Status {
    while (!failed) {
      BOOST_OUTCOME_TRY(index, queue.next());
      if (!index) break;
      BOOST_OUTCOME_TRY(tile, source.read(*index, parts));
      BOOST_OUTCOME_TRYV(work(*index, std::move(tile)));
    }
    return success();
  });
}

}  // namespace tessera::surface
