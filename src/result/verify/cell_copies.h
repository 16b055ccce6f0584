// A cell whose vertices belong to several tiles is held by each of them, and is main in one. The copies must agree.
#pragma once

#include <compare>
#include <cstdint>

#include "src/base/result.h"
#include "src/result/store/external_sort.h"
#include "src/result/verify/place.h"

namespace tessera {

struct CellCopy {
  IdSet ids;
  TileId tile;
  std::uint32_t cell;
  std::uint64_t coordinates;  // XXH3-64 of the vertices' coordinates, in the order of `ids`
  std::uint8_t own;           // bit i: ids[i] is the tile's own
  std::uint8_t main;
  friend bool operator<(const CellCopy& a, const CellCopy& b) {
    return a.ids != b.ids ? a.ids < b.ids : a.tile != b.tile ? a.tile < b.tile : a.cell < b.cell;
  }
};

// For every cell: one copy in each tile that owns one of its vertices, no other copy; the coordinates are the same
// everywhere; the copy of the lowest tile is main, and no other. Then, for any vertex, the tile that owns it holds each
// cell around it exactly once.
Status check_cell_copies(ExternalSort<CellCopy>& copies, int dimension, const TileSource& source);

}  // namespace tessera
