// Final cells: cells whose circumsphere lies strictly inside the tile's box. No foreign point can ever be in conflict
// with them, so they can be written once and forgotten.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "src/base/big_vector.h"
#include "src/geometry/kernel/kernel.h"

namespace tessera {

// Returns the cells of `list` that are not `open`. They have vertices of the tile's own alone.
FinalCells extract_final(const CellList& list, const std::vector<std::uint8_t>& open, int dimension);

// Final cells that are kept for TileTriangulation::collect(): either all, or those that were not written early. In the
// second case `mesh_index` says where they stand in the mesh, behind the early cells.
struct PendingFinals {
  // | its mesh_index: a neighbour that was written early
  static constexpr std::uint32_t written = std::uint32_t{1} << 31;
  FinalCells cells;                     // a neighbour is a row of this list, written | mesh_index, or open
  BigVector<std::uint32_t> mesh_index;  // by row: the number in the mesh; empty: the order follows from the vertices
  BigVector<std::uint32_t> frozen;  // by row, ascending: the number by which the kernel knows the cell; empty: the row
  std::uint32_t early = 0;          // how many cells were written early: cells 0 to early - 1

  std::size_t bytes() const { return cells.rows.bytes() + (mesh_index.size() + frozen.size()) * 4; }
  // Whether collect() can take these cells safely, which may come from a damaged file. `own`: points of the tile.
  bool sound(int dimension, std::uint64_t own) const;
};

// Finds the row of a kept cell by the number by which the kernel knows the cell.
class RowsOfFrozen {
 public:
  // Refers to `finals`, which must be sound and outlive this object.
  explicit RowsOfFrozen(const PendingFinals& finals);
  std::size_t of(std::uint32_t number) const;  // the number of rows when the cell is not kept

 private:
  const PendingFinals& finals_;
  BigVector<std::uint32_t> rows_;
};

// An unordered simplex as a key: its vertices sorted, padded by 0xffffffff in 2D.
using CellKey = std::array<std::uint32_t, 4>;
CellKey cell_key(const std::uint32_t* vertices, int dimension);

struct CellKeyHash {
  std::size_t operator()(const CellKey& key) const noexcept {
    std::uint64_t h = 0;
    for (const std::uint32_t v : key) h = (h ^ v) * 0x9e3779b97f4a7c15u, h ^= h >> 29;
    return h;
  }
};

}  // namespace tessera
