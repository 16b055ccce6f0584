// The cells of a tile in canonical order: each with its least vertex first and the least of the others second, by even
// permutations, and all of them sorted. Rows stay where the kernel has put them: 9 bytes a cell tell the order, and
// what is asked for is turned and translated on the way, so that no second copy of all cells is needed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>

#include "src/base/ids.h"
#include "src/base/result.h"
#include "src/geometry/kernel/kernel.h"
#include "src/geometry/mesh/cell_stream.h"

namespace tessera {

// Of a row's number in SortedCells: it has a foreign vertex, too.
inline constexpr std::uint32_t mixed_row = std::uint32_t{1} << 31;

// Cells with a vertex of the tile's own, by their least vertex. Vertices of rows: 1..own the tile's own, above:
// own + 1 + k foreign vertex k.
struct SortedCells {
  std::span<const CellRow> rows;
  std::span<const std::uint32_t> order;  // row | mixed_row
  std::span<const std::uint32_t> index;  // by k: the vertex in the mesh, own or more
  std::uint32_t own;                     // vertices
  const std::int32_t* place;  // by row: where it is in `order`; and two before the first, for what is no neighbour
};

// What is sorted, in place, and what is told of it.
struct CellsToSort {
  std::span<std::uint32_t> order;      // SortedCells::order
  std::uint32_t first;                 // place of the first one
  std::span<const std::uint32_t> end;  // by own vertex: where those end in `order` whose least vertex it is
  std::span<const TileId> owners;      // by vertex in the mesh
  TileId self;
  std::int32_t* place;  // SortedCells::place
  std::uint8_t* ghost;  // 1: a tile lower than `self` owns a vertex; null: nobody asks
};

// Throws Stopped soon after `stop` is requested.
void sort_cells(int dimension, const SortedCells& cells, const CellsToSort& sorted, const std::stop_token& stop);

// Of `count` cells from `first` on, in order: dimension + 1 vertices in the mesh each; what lies across the facets
// opposite them. REQUIRES: they are sorted.
void copy_vertices(int dimension, const SortedCells& cells, std::size_t first, std::size_t count, std::int32_t* to);
void copy_neighbors(int dimension, const SortedCells& cells, std::size_t first, std::size_t count, std::int32_t* to);
// What one of these tells of all cells, piece by piece.
using CopyCells = void (*)(int, const SortedCells&, std::size_t, std::size_t, std::int32_t*);
Status stream_cells(int dimension, const SortedCells& cells, CopyCells copy, const CellStream::Take& take);

}  // namespace tessera
