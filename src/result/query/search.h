// Which cells meet an area.
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

// Far more than a distance from a plane is rounded by, and far less than anybody sees.
double nearness(const Bounds& bounds);
// Whether a cell has vertices on both sides of the plane, or so near to it.
bool meets_plane(std::span<const Point> cell, const Plane& plane, double near);

struct Found {
  std::map<TileId, std::vector<std::int32_t>> cells;  // the places of main cells by tile, in no order
  std::set<TileId> owners;                            // of the vertices of these cells
  std::uint64_t count = 0;                            // of cells
};

// All main cells that meet the area, each once; or more than `cells_max` of them, when it was no use to look any
// further. Errors: of reading; interrupted.
Result<Found> search(Walker& walker, const Homes& homes, const Manifest& manifest, const Area& area,
                     std::uint64_t cells_max, const std::stop_token& stop);

}  // namespace tessera::query
