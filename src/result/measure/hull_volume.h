// The total of the volumes of all cells without the cells. The cells of a whole triangulation fill the convex hull of
// its vertices once, so their exact volumes add up to that of the hull.
#pragma once

#include <stop_token>
#include <vector>

#include "src/base/result.h"
#include "src/result/tile_source.h"

namespace tessera {

// The volume of the convex hull of all vertices, rounded once; in 2D the area in the plane. Has the bits that the total
// of measure_volumes() has. Reads the vertices of the tiles that may have a corner of the hull, one after the other.
// REQUIRES: a whole triangulation. Errors: those of reading; interrupted.
Result<double> volume_of_hull(const TileSource& source, const std::stop_token& stop);

// Computes the totals of columns again, of those that have one. `whole`: the result that they are of now. Errors: those
// of volume_of_hull().
Status renew_totals(const TileSource& whole, std::vector<ResultColumn>& columns, const std::stop_token& stop);

}  // namespace tessera
