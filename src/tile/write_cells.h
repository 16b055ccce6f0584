// The cells of a tile in canonical order: each with its least vertex first and the least of the others second, by even
// permutations, and all of them sorted.
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>

#include "src/base/ids.h"
#include "src/kernel/kernel.h"

namespace tessera {

// Of a row's number in CellOrder: it has a foreign vertex, too.
inline constexpr std::uint32_t mixed_row = std::uint32_t{1} << 31;

// Cells with a vertex of the tile's own, by their least vertex. Vertices of rows: 1..own the tile's own, above:
// own + 1 + k foreign vertex k.
struct CellOrder {
  std::span<const CellRow> rows;
  std::span<const std::uint32_t> order;  // row | mixed_row
  std::span<const std::uint32_t> end;    // by own vertex: where those end in `order` whose least vertex it is
  std::span<const std::uint32_t> index;  // by k: the vertex in the mesh, own or more
  std::span<const TileId> owners;        // by vertex in the mesh
  TileId self;
};

// Where they go. A row has dimension + 1 entries.
struct WrittenCells {
  std::int32_t* cells;      // vertices in the mesh
  std::int32_t* neighbors;  // rows without the facet; what is no neighbour stays negative
  std::uint8_t* ghost;      // 1: a lower tile owns a vertex
  std::int32_t* place;      // by row: where it has gone
};

// Throws Stopped soon after `stop` is requested.
void write_cells(int dimension, const CellOrder& from, const WrittenCells& to, const std::stop_token& stop);

}  // namespace tessera
