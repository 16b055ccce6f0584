// Numbers as planes: all lowest bytes, all second bytes, and so on. And planes packed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace tessera::store {

inline constexpr std::size_t planes_max = 8;

// Plane p begins at `to` + p * `stride`; all eight are written. REQUIRES: numbers.size() <= stride.
void split_planes(std::span<const std::uint64_t> numbers, std::byte* to, std::size_t stride);
// REQUIRES: of each plane there are as many bytes as numbers. Those that are not given are 0.
void join_planes(std::span<const std::byte* const> planes, std::span<std::uint64_t> numbers);

// As one frame of zstd that tells its size, of at most `room` bytes; how many, or 0 when they would be more.
std::size_t pack_plane(std::span<const std::byte> plane, std::byte* to, std::size_t room);
// True when `from` is such a frame, of exactly as many bytes.
bool unpack_plane(std::span<const std::byte> from, std::span<std::byte> plane);

}  // namespace tessera::store
