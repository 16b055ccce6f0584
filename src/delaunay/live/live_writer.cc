#include "src/delaunay/live/live_writer.h"

#include <atomic>
#include <cstring>
#include <utility>

#include "src/base/on_threads.h"
#include "src/delaunay/update/points_of_mesh.h"
#include "src/tiling/routed_cloud.h"

namespace tessera {

namespace fs = std::filesystem;

Result<const LiveWriter::Rows*> LiveWriter::stored_rows(TileId tile) {
  {
    const std::lock_guard lock(mutex_);
    if (const auto found = stored_.find(tile); found != stored_.end()) return &found->second;
  }
  Rows rows;
  const std::size_t width = row_bytes(source_.manifest().schema);
  if (const auto index = source_.find(tile)) {
    BOOST_OUTCOME_TRY(stored, source_.read(*index, {.cells = false, .rows = true}));
    for (std::size_t v = 0; v < stored.mesh.ids.size(); ++v) {
      const auto row = std::span(stored.rows).subspan(v * width, width);
      rows[stored.mesh.ids[v]].assign(row.begin(), row.end());
    }
  }
  const std::lock_guard lock(mutex_);
  return &stored_.emplace(tile, std::move(rows)).first->second;
}

// A vertex that the stored tile does not have is new, or its owner's file has it.
Result<std::vector<std::byte>> LiveWriter::rows_of(TileId tile, const TileMesh& mesh) {
  const std::size_t width = row_bytes(source_.manifest().schema);
  std::vector<std::byte> out(mesh.ids.size() * width);
  for (std::size_t v = 0; width > 0 && v < mesh.ids.size(); ++v) {
    const std::vector<std::byte>* row = nullptr;
    if (const auto added = rows_.find(mesh.ids[v]); added != rows_.end()) row = &added->second;
    for (const TileId of : {tile, mesh.owners[v]}) {
      if (row) break;
      BOOST_OUTCOME_TRY(stored, stored_rows(of));
      if (const auto found = stored->find(mesh.ids[v]); found != stored->end()) row = &found->second;
    }
    if (!row) return error(Errc::internal, "the attributes of point " + to_string(mesh.ids[v]) + " are not known");
    std::memcpy(&out[v * width], row->data(), width);
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
  BOOST_OUTCOME_TRY(rows, rows_of(tile, mesh));
  const StoreOptions options{.neighbors = manifest.neighbors, .schema = manifest.schema};
  if (kind_in(source_, tile) == TileKind::points) return write_as_points(folder, tile, mesh, rows, options);
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
