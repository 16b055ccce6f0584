// The pieces of contour lines in a tile, linked to lines.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "src/base/result.h"
#include "src/result/terrain/contour_cells.h"

namespace tessera::terrain {

// Sorts the pieces, and calls give(level, edges) for each line of them: the edges that it passes, of a closed one the
// first again at its end.
Status link_pieces(std::vector<Piece>& pieces,
                   const std::function<Status(std::int64_t level, const std::vector<TileEdge>& edges)>& give);

}  // namespace tessera::terrain
