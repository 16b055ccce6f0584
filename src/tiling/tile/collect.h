// Turns a kernel's cells into the canonical arrays of a tile file.
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
  std::vector<Point> points;         // the tile's own, by rank; n points
  std::vector<PointId> ids;          // by rank
  CellRecords cells;                 // vertices: 0 infinite, 1..n own (rank + 1), n + 1 + k foreign vertex k
  std::vector<std::uint8_t> fill;    // by row: 1 for a fill cell of a reduced tile; or empty
  std::vector<SharedPoint> foreign;  // by k
  PendingFinals finals;              // final cells that were taken out earlier: they border the fill
  std::stop_token stop = {};         // collect_cells() throws Stopped soon after it is requested
};

// Makes the tile's mesh. Works in the arrays of the input, and frees them as soon as it can: a tile needs most memory
// here, and fresh pages cost more time than the work.
CollectedTile collect_cells(CollectInput input);

}  // namespace tessera
