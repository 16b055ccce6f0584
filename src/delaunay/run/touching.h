// Which tiles touch each other. In a periodic cloud these may be images of tiles (src/base/image.h).
#pragma once

#include <memory>
#include <vector>

#include "src/base/image.h"
#include "src/base/point.h"
#include "src/tiling/partition.h"

namespace tessera {

// Returns the boxes in which cells can be final: the boxes of the partition. If the tiles are one in another, as random
// ones are, every box is empty. With a period the boxes end at 0 and at the period.
std::shared_ptr<const std::vector<Box>> final_boxes(const std::shared_ptr<const Partition>& partition,
                                                    const Period& period = {});

// Returns by tile, ascending, the tiles with points whose boxes touch its box; for a random partition, the next 32
// tiles by number. `bounds`: by tile, the bounds of its points. With a period images of tiles are among them, also
// images of the tile itself.
std::vector<std::vector<TileId>> touching_tiles(const Partition& partition, const std::vector<Bounds>& bounds,
                                                const Period& period = {});

}  // namespace tessera
