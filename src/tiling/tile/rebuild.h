// A tile's cells again, from its own points and the foreign vertices that it had at the end (docs/design.md, section
// 3): the star of a point among these is its star among all points.
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
  std::uint64_t own;           // the first ones are the tile's own
  std::vector<Point> points;   // both best in Hilbert order
  std::vector<PointId> ids;    // theirs
  std::vector<TileId> owners;  // theirs
  std::stop_token stop = {};   // error interrupted soon after it is requested
};

// The tile's mesh, whatever order it was stored in: cells are sorted, foreign vertices stand by id. Error corrupt, with
// the end of a sentence, when no tile can have left these points: two are equal, all lie in a plane (2D: on a line), or
// a foreign one is no vertex of the tile's cells, or two of these have one id.
Result<TileMesh> rebuild(RebuildInput input);

}  // namespace tessera
