// Finds the cells that meet an area.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <stop_token>
#include <vector>

#include "src/result/query/area.h"
#include "src/result/query/homes.h"
#include "src/result/query/walker.h"

namespace tessera::query {

// A distance far above the rounding of distances from a plane, and far below anything visible.
double nearness(const Bounds& bounds);
// Returns true if a cell has vertices on both sides of the plane, or within `near` of it.
bool meets_plane(std::span<const Point> cell, const Plane& plane, double near);

struct Found {
  std::map<TileId, std::vector<std::int32_t>> cells;  // indices of main cells by tile, in no order
  std::set<TileId> owners;                            // of the vertices of these cells
  std::uint64_t count = 0;                            // of cells
};

// Finds all main cells that meet the area, each once. When there are more than `cells_max` of them, the search ends
// early, and the list is incomplete. Errors: those of reading; interrupted.
Result<Found> search(Walker& walker, const Homes& homes, const Manifest& manifest, const Area& area,
                     std::uint64_t cells_max, const std::stop_token& stop);

}  // namespace tessera::query
