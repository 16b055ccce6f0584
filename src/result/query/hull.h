// The convex hull of a result in the plane.
#pragma once

#include <stop_token>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/result/tile_source.h"

namespace tessera::query {

// Returns the corners counterclockwise from the least one on, without corners on the line between their neighbours.
// Exact. For a 3D result, the hull of its projection. z is 0. Reads only tiles that may have a corner. Errors: those of
// reading; interrupted.
Result<std::vector<Point>> hull_of(const TileSource& source, const std::stop_token& stop);

// The tile's box, within the bounds of all vertices.
Bounds box_of(const Manifest& manifest, TileId tile);

}  // namespace tessera::query
