// What the file of a tile contains.
#pragma once

#include <cstdint>

namespace tessera {

// Cells, or the points from which the cells follow (src/result/store/FORMAT.md).
enum class TileKind : std::uint8_t { cells, points };

}  // namespace tessera
