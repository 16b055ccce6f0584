#include "src/tiling/tile/collected_tile.h"

#include <cstddef>
#include <span>
#include <utility>

#include "src/base/check.h"

namespace tessera {

SortedCells CollectedTile::sorted() const {
  return {{rows.data(), rows.size()}, order, index, own, mesh_index.data() + 2};
}

Status CollectedTile::vertices(const Consumer& take) const {
  return stream_cells(mesh.dimension, sorted(), copy_vertices, take);
}
Status CollectedTile::neighbors(const Consumer& take) const {
  return stream_cells(mesh.dimension, sorted(), copy_neighbors, take);
}

TileMesh CollectedTile::whole(std::span<const std::int32_t> vertices, std::span<const std::int32_t> neighbors) && {
  const SortedCells cells = sorted();
  const std::size_t corners = static_cast<std::size_t>(mesh.dimension) + 1;
  check(vertices.size() == early * corners && neighbors.size() == early * corners, "all cells that were written early");
  mesh.cells.assign(vertices.begin(), vertices.end());
  mesh.neighbors.assign(neighbors.begin(), neighbors.end());
  mesh.cells.resize((early + order.size()) * corners);
  mesh.neighbors.resize((early + order.size()) * corners);
  if (!order.empty()) {
    copy_vertices(mesh.dimension, cells, 0, order.size(), mesh.cells.data() + early * corners);
    copy_neighbors(mesh.dimension, cells, 0, order.size(), mesh.neighbors.data() + early * corners);
  }
  return std::move(mesh);
}

std::uint64_t CollectedTile::bytes() const {
  return mesh.bytes() + rows.size() * sizeof(CellRecord) +
         (order.capacity() + index.capacity() + mesh_index.capacity()) * 4;
}

}  // namespace tessera
