// Makes a tile's cells again from its own points and the foreign vertices that it had at the end: the star of a point
// among these points is its star among all points (docs/design.md, section 3).
#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

#include "src/base/ids.h"
#include "src/base/point.h"
#include "src/base/result.h"
#include "src/geometry/mesh/tile_mesh.h"

namespace tessera {

struct RebuildInput {
  int dimension;
  TileId self;
  std::uint64_t own;           // how many points are the tile's own; they come first
  std::vector<Point> points;   // best in Hilbert order, own and foreign points each
  std::vector<PointId> ids;    // beside points; of images too (src/base/image.h)
  std::vector<TileId> owners;  // beside points; with the offsets of `ids`
  std::stop_token stop = {};   // error interrupted soon after it is requested
};

// Returns the tile's mesh in canonical order, in whatever order the points were stored: cells are sorted, and foreign
// vertices are ordered by id. Error corrupt, with the end of a sentence, when no tile can have left these points: two
// points are equal, all lie in a plane (2D: on a line), a foreign point is no vertex of the tile's cells, two foreign
// vertices have one id, or an id is none.
Result<TileMesh> rebuild(RebuildInput input);

}  // namespace tessera
