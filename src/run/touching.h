// What tiles know of each other from the partition alone.
#pragma once

#include <vector>

#include "src/tile/tile_triangulation.h"
#include "src/tiling/partition.h"

namespace tessera {

// By tile: the box inside which its cells are final. With a random partition there is none: an empty box.
std::vector<Box> final_boxes(const Partition& partition);

// By tile: the tiles that own points and whose boxes touch its own. None with a random partition.
std::vector<std::vector<TileNeighbour>> touching_tiles(const Partition& partition, const std::vector<Bounds>& bounds);

}  // namespace tessera
