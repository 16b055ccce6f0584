// From a kernel's cells to the canonical arrays of a tile file.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "src/base/point.h"
#include "src/kernel/kernel.h"
#include "src/tile/final_cells.h"
#include "src/tile/tile_mesh.h"

namespace tessera {

struct CollectInput {
  enum : std::uint8_t { other = 0, kept = 1, fill = 2 };

  int dimension;
  TileId self;
  std::span<const Point> points;       // the tile's own, by rank
  std::span<const std::uint64_t> ids;  // by rank
  CellList cells;                      // of the kernel
  std::vector<std::uint8_t> held;      // by cell: what it is to this tile
  std::vector<std::int32_t> place;     // by vertex: the rank of a local one, ~k of a foreign one
  std::vector<SharedPoint> foreign;    // by k
  FinalCells final_cells;              // handed out earlier: they border the fill
};

// Works in the input's arrays, and frees them as soon as it can: this is where a tile needs most memory, and fresh pages
// cost more than the work.
TileMesh make_mesh(CollectInput input);

}  // namespace tessera
