// Gathers the duplicates of a whole run, which need not fit into memory, from what each tile has left on scratch.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "src/base/result.h"
#include "src/result/store/tile_store.h"
#include "src/tiling/routed_cloud.h"

namespace tessera {

// Returns what a tile leaves on scratch of its duplicates: the pairs, and how many have other heights. Adds an entry to
// loaded.duplicates. Valid until loaded.duplicates is changed.
std::span<const std::byte> duplicates_to_bytes(LoadedTile& loaded);

// Adds the pairs of all tiles to `out`. Returns how many duplicates have another height than the kept point. `tiles`:
// the entries of all tiles that hold points; their numbers of vertices tell how many pairs there are. Pairs whose
// scratch is missing or damaged are found again from the points.
Result<std::uint64_t> gather_duplicates(const RoutedCloud& run, const std::vector<TileEntry>& tiles,
                                        DuplicateSort& out);

}  // namespace tessera
