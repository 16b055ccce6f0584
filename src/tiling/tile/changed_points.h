// What a tile of a stored result keeps when points are removed and added, and which of its points are fresh
// (docs/updates-design.md).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "src/base/ids.h"
#include "src/base/point.h"
#include "src/geometry/mesh/tile_mesh.h"
#include "src/tiling/tile/point_ids.h"

namespace tessera {

struct ChangedPoints {
  std::vector<LocalPoint> own;       // the tile's own points that stay, in the order of the mesh, then the new ones
  std::vector<std::uint8_t> fresh;   // beside own
  std::vector<SharedPoint> foreign;  // foreign vertices that stay
  bool lost = false;                 // an own point was removed
  bool reshaped = false;             // a point of the tile, removed or not, is beside a hole that is filled

  // Whether the tile takes part in the exchange from the start.
  bool begins() const;
};

// `mesh`: the stored tile `self`, with all its cells. `removed`: vertices of the result, of any tiles. `added`: new
// points of this tile, with ids and coordinates that no vertex that stays has. `filled`: those of the removed points
// around which the tile knows all points. Their neighbours do not count as fresh.
ChangedPoints change_points(const TileMesh& mesh, TileId self, const PointIds& removed,
                            std::span<const LocalPoint> added, const PointIds& filled = {});

}  // namespace tessera
