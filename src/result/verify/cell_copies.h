// A cell whose vertices belong to several tiles is in the file of each of them, and is main in one. The copies must
// agree.
#pragma once

#include <compare>
#include <cstdint>

#include "src/base/result.h"
#include "src/result/store/external_sort.h"
#include "src/result/verify/cell_ref.h"

namespace tessera {

struct CellCopy {
  IdSet ids;
  TileId tile;
  std::uint32_t cell;
  std::uint64_t coordinates;  // XXH3-64 of the vertices' coordinates, in the order of `ids`
  std::uint8_t own;           // bit i: ids[i] is the tile's own vertex
  std::uint8_t main;
  std::uint8_t first;  // of the copies in this tile it is the one that can be main
  friend bool operator<(const CellCopy& a, const CellCopy& b) {
    return a.ids != b.ids ? a.ids < b.ids : a.tile != b.tile ? a.tile < b.tile : a.cell < b.cell;
  }
};

// In a periodic result a tile may have several copies of a cell, shifted by periods: one for each offset that the
// tile's points have in the cell. Own are then the vertices whose offset is 0.
//
// Checks every cell: each tile that owns one of its vertices has exactly one copy, and no other tile has one; all
// copies have the same coordinates; the (first) copy of the lowest tile is main, and no other is. It follows that the
// tile that owns a vertex has every cell around the vertex exactly once.
Status check_cell_copies(ExternalSort<CellCopy>& copies, int dimension, const TileSource& source);

}  // namespace tessera
