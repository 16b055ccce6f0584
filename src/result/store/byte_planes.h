// Splits numbers into byte planes (all lowest bytes, all second bytes, and so on), and packs planes with zstd.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace tessera::store {

inline constexpr std::size_t planes_max = 8;

// Writes all eight planes; plane p begins at `to` + p * `stride`. REQUIRES: numbers.size() <= stride.
void split_planes(std::span<const std::uint64_t> numbers, std::byte* to, std::size_t stride);
// The inverse of split_planes(). Planes that are not given are zeros. REQUIRES: each plane has as many bytes as there
// are numbers.
void join_planes(std::span<const std::byte* const> planes, std::span<std::uint64_t> numbers);

// Packs a plane as one zstd frame that contains its size. Returns the number of bytes, or 0 when `room` bytes are too
// few.
std::size_t pack_plane(std::span<const std::byte> plane, std::byte* to, std::size_t room);
// Returns true when `from` is such a frame of exactly plane.size() bytes.
bool unpack_plane(std::span<const std::byte> from, std::span<std::byte> plane);

}  // namespace tessera::store
