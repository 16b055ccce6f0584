// What the removal of points does to the tiles around them (docs/updates-design.md): a hole is a set of removed points
// that edges of the stored triangulation join. Without these points the triangulation has new cells only among the
// points around the hole. So a tile that knows all of them has the true stars of its own points at once, and the
// exchange need not know of the hole.
#pragma once

#include <vector>

#include "src/base/ids.h"
#include "src/base/point.h"
#include "src/geometry/mesh/tile_mesh.h"
#include "src/tiling/tile/point_ids.h"

namespace tessera {

// As the owner of some of its removed points knows it.
struct Hole {
  std::vector<PointId> removed;     // points of the owner, ascending
  std::vector<SharedPoint> around;  // points that stay and that an edge joins to a removed point, by id
  std::vector<TileId> beside;       // the other tiles with a vertex in a cell with a removed point, ascending
  bool whole = false;  // one tile owns all removed points of the hole, so `around` has all points around it
};

// Returns the holes with removed points of the tile `self`. `stored`: the tile with its cells.
std::vector<Hole> find_holes(TileId self, const TileMesh& stored, const PointIds& removed);

}  // namespace tessera
