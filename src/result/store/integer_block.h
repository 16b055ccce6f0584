// Packs blocks of similar integers: first what they have in common is subtracted, then the rest is split into byte
// planes (all lowest bytes, all second bytes, and so on), and zstd packs each plane that gets smaller. Noise then stays
// in planes of its own, unpacked, and costs no time. The other planes have few different bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "src/base/big_vector.h"

namespace tessera::store {

// The most rows of a block. Among 4096 to 65536 rows, this is the smallest number with nearly the fewest bytes and the
// shortest times in bench/store/bench_points_file.cc. Fewer rows need more tables; with more rows, reading a single row
// takes longer.
inline constexpr std::size_t block_rows = 16384;

// Packs and unpacks blocks. Keeps its buffers, so that the next block needs no new memory. Not thread-safe.
class IntegerBlocks {
 public:
  // Appends the numbers to `to` as one block. Equal numbers give equal bytes with the same version of zstd. REQUIRES: 1
  // to block_rows numbers.
  void append(std::span<const std::uint64_t> numbers, BigVector<std::byte>& to);
  // Reads numbers.size() numbers, as many as append() wrote, from the front of `from`, and removes them from `from`.
  // Returns null, or what is wrong with them, as the end of a sentence about the block.
  const char* take(std::span<const std::byte>& from, std::span<std::uint64_t> numbers);
  // True when take() would read only zeros. Costs no unpacking.
  static bool says_zeros(std::span<const std::byte> from);

 private:
  BigVector<std::uint64_t> moved_;
  BigVector<std::byte> planes_;
};

// All bits equal to the highest bit.
constexpr std::uint64_t sign_of(std::uint64_t bits) {
  return static_cast<std::uint64_t>(static_cast<std::int64_t>(bits) >> 63);
}
// Maps signed differences to unsigned numbers: 0, -1, 1, -2, ... become 0, 1, 2, 3, ... So small differences stay
// small.
constexpr std::uint64_t folded(std::uint64_t difference) { return difference << 1u ^ sign_of(difference); }
constexpr std::uint64_t unfolded(std::uint64_t number) { return number >> 1u ^ (0 - (number & 1u)); }

}  // namespace tessera::store
