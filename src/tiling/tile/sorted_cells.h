// The cells of a tile in canonical order: each has its least vertex first and the second least next, by even
// permutations, and all cells are sorted. Rows stay where the kernel has put them. 9 bytes a cell tell the order, and
// cells are turned and translated when they are copied, so no second copy of all cells is needed.
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

// In SortedCells::order, a bit beside a row's number: the cell has a foreign vertex, too.
inline constexpr std::uint32_t mixed_row = std::uint32_t{1} << 31;

// Cells with a vertex of the tile's own, by their least vertex. Vertices in rows: 1..own are the tile's own, and own +
// 1 + k is foreign vertex k.
struct SortedCells {
  std::span<const CellRecord> rows;
  std::span<const std::uint32_t> order;  // row | mixed_row
  std::span<const std::uint32_t> index;  // by k: the foreign vertex in the mesh, own or more
  std::uint32_t own;                     // number of the tile's own vertices
  // by row: where it is in `order`; the two entries before the first stand for facets without a neighbour
  const std::int32_t* mesh_index;
};

// What sort_cells() sorts in place, and what it writes.
struct CellsToSort {
  std::span<std::uint32_t> order;      // SortedCells::order
  std::uint32_t first;                 // number of the first cell of `order` in the mesh
  std::span<const std::uint32_t> end;  // by own vertex: where the cells with this least vertex end in `order`
  std::span<const TileId> owners;      // by vertex in the mesh; where there are images, rank_of() them and of `self`
  TileId self;
  std::int32_t* mesh_index;  // SortedCells::mesh_index
  std::uint8_t* ghost;       // 1: a tile lower than `self` owns a vertex; null: not wanted
};

// Throws Stopped soon after `stop` is requested.
void sort_cells(int dimension, const SortedCells& cells, const CellsToSort& sorted, const std::stop_token& stop);

// Copy the cells `first` to first + count - 1, in order, dimension + 1 numbers each: vertices in the mesh, or the cells
// across the opposite facets. REQUIRES: the cells are sorted.
void copy_vertices(int dimension, const SortedCells& cells, std::size_t first, std::size_t count, std::int32_t* to);
void copy_neighbors(int dimension, const SortedCells& cells, std::size_t first, std::size_t count, std::int32_t* to);
// Streams all cells through `copy`, one of these two functions, piece by piece.
using CopyCells = void (*)(int, const SortedCells&, std::size_t, std::size_t, std::int32_t*);
Status stream_cells(int dimension, const SortedCells& cells, CopyCells copy, const CellStream::Consumer& take);

}  // namespace tessera
