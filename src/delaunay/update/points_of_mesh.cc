#include "src/delaunay/update/points_of_mesh.h"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <utility>
#include <vector>

#include "src/result/store/digest.h"
#include "src/result/store/points_tile.h"
#include "src/tiling/hilbert.h"

namespace tessera {

TileKind kind_in(const TileSource& result, TileId tile) {
  if (const auto index = result.find(tile)) return result.entry(*index).kind;
  const auto& all = result.manifest().tiles;
  const bool points = std::all_of(all.begin(), all.end(), [](const auto& e) { return e.kind == TileKind::points; });
  return points ? TileKind::points : TileKind::cells;
}

Result<TileEntry> write_as_points(const std::filesystem::path& out, TileId tile, const TileMesh& mesh,
                                  std::span<const std::byte> rows, const StoreOptions& options) {
  const auto own = static_cast<std::size_t>(std::count(mesh.point_ghost.begin(), mesh.point_ghost.end(), 0));
  Bounds bounds;
  for (std::size_t v = own; v < mesh.points.size(); ++v) bounds.add(mesh.points[v]);
  const HilbertKey key(bounds, mesh.dimension);
  std::vector<std::size_t> order(mesh.points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin() + static_cast<std::ptrdiff_t>(own), order.end(), [&](std::size_t a, std::size_t b) {
    return std::pair(key(mesh.points[a]), mesh.ids[a]) < std::pair(key(mesh.points[b]), mesh.ids[b]);
  });
  std::vector<Point> points;
  std::vector<PointId> ids;
  std::vector<TileId> owners;
  std::vector<std::byte> ordered(rows.size());
  const std::size_t width = row_bytes(options.schema);
  for (const std::size_t v : order) {
    if (width > 0) std::memcpy(&ordered[points.size() * width], &rows[v * width], width);
    points.push_back(mesh.points[v]);
    ids.push_back(mesh.ids[v]);
    owners.push_back(mesh.owners[v]);
  }
  CountedCells counted;
  counted.cells = mesh.cell_ghost.size();
  counted.main_cells = static_cast<std::uint64_t>(std::count(mesh.cell_ghost.begin(), mesh.cell_ghost.end(), 0));
  counted.digest = CellDigest(mesh.dimension, mesh.ids).of(mesh.cells, mesh.cell_ghost.data());
  return write_points_tile(out,
                           {.dimension = mesh.dimension,
                            .tile = tile,
                            .own = own,
                            .points = points,
                            .ids = ids,
                            .owners = owners,
                            .schema = options.schema,
                            .rows = ordered},
                           counted, options);
}

}  // namespace tessera
