// Links the pieces of contour lines in a tile.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "src/base/result.h"
#include "src/result/terrain/contour_cells.h"

namespace tessera::terrain {

// Sorts the pieces, and calls give(level, edges) for each line: the edges that it crosses. A closed line ends with its
// first edge again.
Status link_pieces(std::vector<Piece>& pieces,
                   const std::function<Status(std::int64_t level, const std::vector<TileEdge>& edges)>& give);

}  // namespace tessera::terrain
