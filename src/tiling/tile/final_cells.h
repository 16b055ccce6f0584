// Final cells: those whose circumsphere lies strictly inside the tile's box. No foreign point can ever enter them, so
// they can be written once and forgotten.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "src/base/big_vector.h"
#include "src/geometry/kernel/kernel.h"

namespace tessera {

// The cells of `list` that are not `open`. They have vertices of the tile's own alone.
FinalCells extract_final(const CellList& list, const std::vector<std::uint8_t>& open, int dimension);

// Final cells that are kept for TileTriangulation::collect(): all of them; or those that were not written early, of
// which `place` tells where they stand in the mesh, behind the written ones.
struct PendingFinals {
  static constexpr std::uint32_t written = std::uint32_t{1} << 31;  // | its place: a neighbour that is not kept
  FinalCells cells;                 // a neighbour is a row of this list, written | place, or open
  BigVector<std::uint32_t> place;   // by row; none: where their vertices say
  BigVector<std::uint32_t> frozen;  // by row, ascending: the number the kernel knows it by; none: the row
  std::uint32_t early = 0;          // how many were written: cells 0 to early - 1

  std::size_t bytes() const { return cells.rows.bytes() + (place.size() + frozen.size()) * 4; }
  // Whether a file of them, which anybody may have written, is none that breaks collect(). `own`: points of the tile.
  bool sound(int dimension, std::uint64_t own) const;
};

// The rows of kept cells by the number that the kernel knows them by.
class RowsOfFrozen {
 public:
  // Refers to `finals`, which are sound.
  explicit RowsOfFrozen(const PendingFinals& finals);
  std::size_t of(std::uint32_t number) const;  // the end when it is none of these

 private:
  const PendingFinals& finals_;
  BigVector<std::uint32_t> rows_;
};

// An unordered simplex as a key: its members sorted, padded by 0xffffffff in 2D.
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
