// Which tiles store their first cells before the others are known (src/result/store/early_cells.h).
#pragma once

#include <cstdint>

namespace tessera {

// Tiles of at least so many points of their own, of a cloud of so many, duplicates included; 0: none. Others are stored
// in one go: to write them twice costs more time than they take memory. What a tile's file looks like depends on it.
constexpr std::uint64_t early_points_of(std::uint64_t cloud) {
  constexpr std::uint64_t points_min = std::uint64_t{1} << 15, cloud_min = std::uint64_t{1} << 22;
  return cloud < cloud_min ? 0 : points_min;
}

}  // namespace tessera
