// The duplicates of a whole run, which may be more than fit into memory, from what each tile has left of its own.
#pragma once

#include <cstdint>
#include <vector>

#include "src/base/result.h"
#include "src/store/tile_store.h"
#include "src/tiling/routed_run.h"

namespace tessera {

// Adds the pairs of all tiles to `out`. `tiles`: the entries of all that hold points; their numbers of vertices tell
// how many pairs there are. What is missing or damaged is found again from the points.
Status gather_duplicates(const RoutedRun& run, const std::vector<TileEntry>& tiles, DuplicateSort& out);

}  // namespace tessera
