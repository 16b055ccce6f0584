// Which tiles touch each other.
#pragma once

#include <memory>
#include <vector>

#include "src/base/point.h"
#include "src/tiling/partition.h"

namespace tessera {

// Returns the boxes in which cells can be final: the boxes of the partition. If the tiles are one in another, as random
// ones are, every box is empty.
std::shared_ptr<const std::vector<Box>> final_boxes(const std::shared_ptr<const Partition>& partition);

// Returns by tile, ascending, the tiles with points whose boxes touch its box; for a random partition, the next 32
// tiles by number. `bounds`: by tile, the bounds of its points.
std::vector<std::vector<TileId>> touching_tiles(const Partition& partition, const std::vector<Bounds>& bounds);

}  // namespace tessera
