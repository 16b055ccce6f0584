#include "src/delaunay/live/live_writer.h"

#include <atomic>
#include <cstring>
#include <memory>
#include <span>
#include <utility>

#include "src/base/on_threads.h"
#include "src/delaunay/update/points_of_mesh.h"
#include "src/tiling/routed_cloud.h"

namespace tessera {

namespace fs = std::filesystem;

// A vertex that is stored is in the file of its owner, and mostly in that of the tile. A part of a split tile has the
// file of the whole tile.
Result<std::vector<std::byte>> LiveWriter::rows_of(const TileMesh& mesh, TileId home) {
  const std::size_t width = row_bytes(source_.manifest().schema);
  std::vector<std::byte> out(mesh.ids.size() * width);
  std::shared_ptr<const RowsOfTile> of_tile;  // that was read last
  for (std::size_t v = 0; width > 0 && v < mesh.ids.size(); ++v) {
    std::span<const std::byte> row;
    if (const auto added = rows_.unstored().find(mesh.ids[v]); added != rows_.unstored().end()) row = added->second;
    for (const TileId tile : {home, stored_.tile_of(mesh.points[v])}) {
      if (!row.empty()) break;
      BOOST_OUTCOME_TRY(stored, stored_rows_.of(tile));
      of_tile = std::move(stored);
      row = of_tile->find(mesh.ids[v]);
    }
    if (row.empty())
      return error(Errc::internal, "the attributes of point " + to_string(mesh.ids[v]) + " are not known");
    std::memcpy(&out[v * width], row.data(), width);
  }
  return out;
}

Result<TileEntry> LiveWriter::write_one(TileId tile, const fs::path& folder) {
  const Manifest& manifest = source_.manifest();
  const TileTriangulation& live = version_.tiles()[tile.value]->triangulation();
  const LoadedTile ordered = order_points(live.own(), manifest.dimension);
  std::vector<LocalPoint> order;
  for (std::size_t i = 0; i < ordered.ids.size(); ++i) order.push_back({ordered.points[i], ordered.ids[i]});
  const TileMesh mesh = live.mesh(order);
  const TileId home = stored_.tile_of(order.front().at);
  BOOST_OUTCOME_TRY(rows, rows_of(mesh, home));
  const StoreOptions options{.neighbors = manifest.neighbors, .schema = manifest.schema};
  if (kind_in(source_, home) == TileKind::points) return write_as_points(folder, tile, mesh, rows, options);
  return write_tile(folder, tile, mesh, rows, options);
}

Result<std::vector<TileEntry>> LiveWriter::write(const std::set<TileId>& tiles, const fs::path& folder,
                                                 unsigned threads) {
  std::vector<TileId> work;
  for (const TileId tile : tiles) {
    if (version_.tiles()[tile.value]) work.push_back(tile);
  }
  std::vector<TileEntry> out(work.size());
  std::atomic<bool> failed{false};
  std::atomic<std::size_t> next{0};
  BOOST_OUTCOME_TRYV(on_threads(threads, failed, [&]() -> Status {
    for (std::size_t i = next++; i < work.size() && !failed; i = next++) {
      BOOST_OUTCOME_TRY(entry, write_one(work[i], folder));
      out[i] = entry;
    }
    return success();
  }));
  return out;
}

}  // namespace tessera
