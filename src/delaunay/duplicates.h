// Gathers the duplicates of a whole run, which need not fit into memory, from what each tile has left on scratch.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "src/base/result.h"
#include "src/result/store/duplicate_rows.h"
#include "src/result/store/tile_store.h"
#include "src/tiling/routed_cloud.h"

namespace tessera {

// Returns what a tile leaves on scratch of its duplicates: the pairs (duplicate, kept), and one more pair, whose first
// number says how many of the duplicates have other heights.
std::vector<std::pair<PointId, PointId>> duplicates_for_scratch(std::vector<std::pair<PointId, PointId>> duplicates,
                                                                std::uint64_t other_heights);

// Adds the pairs of all tiles to `out`. Returns how many duplicates have another height than the kept point. `tiles`:
// the entries of all tiles that hold points; their numbers of vertices tell how many pairs there are. Pairs whose
// scratch is missing or damaged are found again from the points. Adds the attributes of the duplicates to `rows`, if
// given.
Result<std::uint64_t> gather_duplicates(const RoutedCloud& run, const std::vector<TileEntry>& tiles, DuplicateSort& out,
                                        DuplicateRowSort* rows = nullptr);

}  // namespace tessera
