#include "src/delaunay/live/live_writer.h"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <numeric>
#include <utility>

#include "src/base/on_threads.h"
#include "src/result/store/digest.h"
#include "src/result/store/points_tile.h"
#include "src/tiling/hilbert.h"
#include "src/tiling/routed_cloud.h"

namespace tessera {

namespace fs = std::filesystem;

// A tile without a file gets one like the others.
TileKind LiveWriter::kind_of(TileId tile) const {
  if (const auto index = source_.find(tile)) return source_.entry(*index).kind;
  const auto& all = source_.manifest().tiles;
  const bool points = std::all_of(all.begin(), all.end(), [](const auto& e) { return e.kind == TileKind::points; });
  return points ? TileKind::points : TileKind::cells;
}

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

// Foreign vertices are in Hilbert order in such files.
Result<TileEntry> LiveWriter::write_points(TileId tile, const TileMesh& mesh, std::span<const std::byte> rows,
                                           const fs::path& folder) const {
  const Manifest& manifest = source_.manifest();
  const auto own = static_cast<std::size_t>(std::count(mesh.point_ghost.begin(), mesh.point_ghost.end(), 0));
  Bounds bounds;
  for (std::size_t v = own; v < mesh.points.size(); ++v) bounds.add(mesh.points[v]);
  const HilbertKey key(bounds, manifest.dimension);
  std::vector<std::size_t> order(mesh.points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin() + static_cast<std::ptrdiff_t>(own), order.end(), [&](std::size_t a, std::size_t b) {
    return std::pair(key(mesh.points[a]), mesh.ids[a]) < std::pair(key(mesh.points[b]), mesh.ids[b]);
  });
  PointsTile out;
  out.dimension = manifest.dimension;
  out.tile = tile;
  out.own = own;
  out.schema = manifest.schema;
  const std::size_t width = row_bytes(manifest.schema);
  for (const std::size_t v : order) {
    out.points.push_back(mesh.points[v]);
    out.ids.push_back(mesh.ids[v]);
    out.owners.push_back(mesh.owners[v]);
    const auto row = rows.subspan(v * width, width);
    out.rows.insert(out.rows.end(), row.begin(), row.end());
  }
  CountedCells counted;
  counted.cells = mesh.cell_ghost.size();
  counted.main_cells = static_cast<std::uint64_t>(std::count(mesh.cell_ghost.begin(), mesh.cell_ghost.end(), 0));
  counted.digest = CellDigest(manifest.dimension, mesh.ids).of(mesh.cells, mesh.cell_ghost.data());
  return write_points_tile(folder, view_of(out), counted, {.schema = manifest.schema});
}

Result<TileEntry> LiveWriter::write_one(TileId tile, const fs::path& folder) {
  const Manifest& manifest = source_.manifest();
  const TileTriangulation& live = version_.tiles()[tile.value]->triangulation();
  const LoadedTile ordered = order_points(live.own(), manifest.dimension);
  std::vector<LocalPoint> order;
  for (std::size_t i = 0; i < ordered.ids.size(); ++i) order.push_back({ordered.points[i], ordered.ids[i]});
  const TileMesh mesh = live.mesh(order);
  BOOST_OUTCOME_TRY(rows, rows_of(tile, mesh));
  if (kind_of(tile) == TileKind::points) return write_points(tile, mesh, rows, folder);
  return write_tile(folder, tile, mesh, rows, {.neighbors = manifest.neighbors, .schema = manifest.schema});
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
