// New points at the places of others, in results in which a new point may take the place of a vertex.
#pragma once

#include <cstddef>
#include <span>

#include "src/base/result.h"
#include "src/delaunay/update/update_plan.h"
#include "src/result/tile_source.h"

namespace tessera {

// Decides for each place with a new point which point is the vertex, by the policy of the result. Afterwards no two
// points of plan.added are equal, none is equal to a vertex that stays, and all duplicates are in plan.duplicates.
// Reads the own points of the tiles that get new points. `rows`: of the new points.
Status place_equal_points(const TileSource& source, std::span<const std::byte> rows, UpdatePlan& plan);

// The height in a row, `at` being height_offset().
double height_in(std::span<const std::byte> row, std::size_t at);

}  // namespace tessera
