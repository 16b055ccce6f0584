// From a kernel's cells to the canonical arrays of a tile file.
#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

#include "src/base/point.h"
#include "src/geometry/kernel/kernel.h"
#include "src/geometry/mesh/tile_mesh.h"
#include "src/tiling/tile/collected_tile.h"
#include "src/tiling/tile/final_cells.h"

namespace tessera {

struct CollectInput {
  int dimension;
  TileId self;
  std::vector<Point> points;         // the tile's own, by rank: n
  std::vector<PointId> ids;          // by rank
  CellRows cells;                    // vertices: 0 infinite, 1..n own (rank + 1), above: n + 1 + k foreign
  std::vector<std::uint8_t> fill;    // by row: 1 for fill of a reduced tile; or empty
  std::vector<SharedPoint> foreign;  // by k
  PendingFinals finals;              // handed out earlier: they border the fill
  std::stop_token stop = {};         // Stopped is thrown soon after it is requested
};

// Works in the input's arrays, and frees them as soon as it can: this is where a tile needs most memory, and fresh
// pages cost more than the work.
CollectedTile collect_cells(CollectInput input);

}  // namespace tessera
