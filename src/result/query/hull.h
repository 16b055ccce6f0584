// The convex hull of a result in the plane.
#pragma once

#include <stop_token>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/result/tile_source.h"

namespace tessera::query {

// Counterclockwise from the least corner on, none on the line between its neighbours: exact. Of a 3D result that of its
// projection. z is 0. Only tiles that may hold a corner are read. Errors: of reading; interrupted.
Result<std::vector<Point>> hull_of(const TileSource& source, const std::stop_token& stop);

// The part of space that is the tile's, within the bounds of all vertices.
Bounds box_of(const Manifest& manifest, TileId tile);

}  // namespace tessera::query
