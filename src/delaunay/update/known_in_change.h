// What the tiles of a change know of each other before any message: where they are, and which of them touch.
#pragma once

#include <span>

#include "src/base/ids.h"
#include "src/tiling/partition.h"
#include "src/tiling/tile/known_from_start.h"

namespace tessera {

// `tiles`: those that may have points, before or after the change. The bounds of the others are empty. There are no
// seeds. Told bits save messages between tiles that touch.
KnownFromStart known_in_change(const Partition& partition, std::span<const TileId> tiles);
// The same for all tiles of the partition.
KnownFromStart known_in_change(const Partition& partition);

}  // namespace tessera
