// Which tiles have to do with each other from the start.
#pragma once

#include <memory>
#include <vector>

#include "src/base/point.h"
#include "src/tiling/partition.h"

namespace tessera {

// Where cells can be final: the boxes of the partition; of tiles that lie in one another, as random ones do, the empty
// box.
std::shared_ptr<const std::vector<Box>> final_boxes(const std::shared_ptr<const Partition>& partition);

// By tile, ascending: those with points whose boxes touch its own; of a random partition, the next 32 in number.
// `bounds`: of the tiles' points.
std::vector<std::vector<TileId>> touching_tiles(const Partition& partition, const std::vector<Bounds>& bounds);

}  // namespace tessera
