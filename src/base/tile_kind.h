// What the file of a tile holds.
#pragma once

#include <cstdint>

namespace tessera {

// Cells, or the points that they follow from (src/result/store/FORMAT.md).
enum class TileKind : std::uint8_t { cells, points };

}  // namespace tessera
