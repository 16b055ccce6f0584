// Blocks of integers that are alike, small: what they have in common is taken off, then they are cut into planes, all
// lowest bytes, all second bytes and so on, each of which is packed by zstd where that helps. Noise then stays in
// planes of its own, as it is, and costs no time; what is left of the rest are bytes of few values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "src/base/big_vector.h"

namespace tessera::store {

// Of a block, at most. Of 4096 to 65536 rows, this many are the fewest with which bytes and times are the least, by
// bench/store/bench_points_file.cc: fewer rows take more tables, more take longer where one row is wanted.
inline constexpr std::size_t block_rows = 16384;

// Has the memory that blocks need on their way, so that the next block takes no new one. Of one thread at a time.
class IntegerBlocks {
 public:
  // REQUIRES: 1 to block_rows numbers. Equal numbers make equal bytes, with one version of zstd.
  void append(std::span<const std::uint64_t> numbers, BigVector<std::byte>& to);
  // Reads as many numbers as append() wrote from the front of `from`, and takes that off. What is wrong with them, as
  // the end of a sentence about the block; null when nothing is.
  const char* take(std::span<const std::byte>& from, std::span<std::uint64_t> numbers);
  // What take() would read are zeros, which shows at once.
  static bool says_zeros(std::span<const std::byte> from);

 private:
  BigVector<std::uint64_t> moved_;
  BigVector<std::byte> planes_;
};

// All bits those of the highest one.
constexpr std::uint64_t sign_of(std::uint64_t bits) {
  return static_cast<std::uint64_t>(static_cast<std::int64_t>(bits) >> 63);
}
// Signed differences as unsigned numbers, 0, -1, 1, -2, ...: small ones stay small.
constexpr std::uint64_t folded(std::uint64_t difference) { return difference << 1u ^ sign_of(difference); }
constexpr std::uint64_t unfolded(std::uint64_t number) { return number >> 1u ^ (0 - (number & 1u)); }

}  // namespace tessera::store
