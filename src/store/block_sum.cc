#include "src/store/block_sum.h"

#include <array>

namespace tessera::store {

// Adler-32 is (a, b) with a = 1 + the bytes' sum and b = the sum of all values that a takes, modulo 65521. So the byte
// at i counts n - i times in b. In rows of 16 bytes, n - i = 16 (rows - r) - j, and adding the columns' sums up row by
// row counts the byte of row r just rows - r times. Sums stay below 2^32: 255 x 4096 x 4097 / 2.
std::uint32_t block_sum(std::span<const std::byte> bytes) {
  constexpr std::size_t width = 16;
  constexpr std::uint64_t modulus = 65521;
  std::array<std::uint32_t, width> sums{}, sums_of_sums{};
  const std::size_t rows = bytes.size() / width;
  const std::byte* row = bytes.data();
  for (std::size_t r = 0; r < rows; ++r, row += width) {
#pragma GCC unroll 1  // unrolled before it makes vectors of it, g++ -O3 makes none
    for (std::size_t j = 0; j < width; ++j) {
      sums[j] += static_cast<std::uint32_t>(row[j]);
      sums_of_sums[j] += sums[j];
    }
  }
  std::uint64_t a = 1, b = rows * width;
  for (std::size_t j = 0; j < width; ++j) {
    a += sums[j];
    b += width * std::uint64_t{sums_of_sums[j]} - j * std::uint64_t{sums[j]};
  }
  for (const std::byte byte : bytes.subspan(rows * width)) {
    a += static_cast<std::uint64_t>(byte);
    b += a;
  }
  return static_cast<std::uint32_t>(b % modulus << 16u | a % modulus);
}

}  // namespace tessera::store
