#include "src/tile/collected_tile.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <utility>

namespace tessera {
namespace {

constexpr std::size_t piece_cells = 1024;  // 16 KiB: they stay in the first-level cache until they are taken

template <class Copy>
Status in_pieces(const CollectedTile& tile, const Copy& copy, const CellStream::Take& take) {
  const SortedCells cells = tile.sorted();
  const std::size_t corners = static_cast<std::size_t>(tile.mesh.dimension) + 1;
  std::array<std::int32_t, 4 * piece_cells> piece;
  for (std::size_t first = 0; first < cells.order.size(); first += piece_cells) {
    const std::size_t count = std::min(piece_cells, cells.order.size() - first);
    copy(tile.mesh.dimension, cells, first, count, piece.data());
    BOOST_OUTCOME_TRYV(take(std::span(piece).first(count * corners)));
  }
  return success();
}

}  // namespace

SortedCells CollectedTile::sorted() const { return {{rows.data(), rows.size()}, order, index, own, places.data() + 2}; }

Status CollectedTile::vertices(const Take& take) const { return in_pieces(*this, copy_vertices, take); }
Status CollectedTile::neighbors(const Take& take) const { return in_pieces(*this, copy_neighbors, take); }

TileMesh CollectedTile::whole() && {
  const SortedCells cells = sorted();
  const std::size_t corners = static_cast<std::size_t>(mesh.dimension) + 1;
  mesh.cells.resize(order.size() * corners);
  mesh.neighbors.resize(order.size() * corners);
  if (!order.empty()) {
    copy_vertices(mesh.dimension, cells, 0, order.size(), mesh.cells.data());
    copy_neighbors(mesh.dimension, cells, 0, order.size(), mesh.neighbors.data());
  }
  return std::move(mesh);
}

std::uint64_t CollectedTile::bytes() const {
  return mesh.bytes() + rows.size() * sizeof(CellRow) + (order.capacity() + index.capacity() + places.capacity()) * 4;
}

}  // namespace tessera
