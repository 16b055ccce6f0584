// The duplicates of a whole run, which may be more than fit into memory, from what each tile has left of its own.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "src/base/result.h"
#include "src/result/store/tile_store.h"
#include "src/tiling/routed_cloud.h"

namespace tessera {

// What a tile leaves on scratch of its duplicates: the pairs and how many are at other heights. Valid as long as they
// are not changed.
std::span<const std::byte> duplicates_to_bytes(LoadedTile& loaded);

// Adds the pairs of all tiles to `out`, and tells how many are at other heights than the kept points. `tiles`: the
// entries of all that hold points; their numbers of vertices tell how many pairs there are. What is missing or damaged
// is found again from the points.
Result<std::uint64_t> gather_duplicates(const RoutedCloud& run, const std::vector<TileEntry>& tiles,
                                        DuplicateSort& out);

}  // namespace tessera
