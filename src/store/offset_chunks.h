// The Offsets array of a tile is 0, s, 2s, ... for every tile: its compressed chunks are made once and shared.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace tessera::store {

inline constexpr std::uint64_t offsets_per_chunk = 65536;

// Entries [first, first + count) of the sequence i * step as little-endian i32, shuffled and deflated the way HDF5's
// shuffle and deflate filters would. Whole chunks are kept for the next tile.
std::shared_ptr<const std::vector<std::byte>> offsets_chunk(std::uint64_t first, std::uint64_t count, int step);

}  // namespace tessera::store
