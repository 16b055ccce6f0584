// Which tiles store their early cells before the others are known (src/result/store/early_cells.h).
#pragma once

#include <cstdint>

namespace tessera {

// Returns the least number of own points with which a tile of a cloud of `cloud` points (duplicates included) stores
// cells early; 0: no tile does. Smaller tiles are stored at once: two writes cost more time than the memory is worth.
// The layout of a tile's file depends on it.
constexpr std::uint64_t early_points_of(std::uint64_t cloud) {
  constexpr std::uint64_t points_min = std::uint64_t{1} << 15, cloud_min = std::uint64_t{1} << 22;
  return cloud < cloud_min ? 0 : points_min;
}

}  // namespace tessera
