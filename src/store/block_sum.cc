#include "src/store/block_sum.h"

#include <array>
#include <cstring>

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wpsabi"  // vectors are passed to functions that are always inlined
#endif

namespace tessera::store {
namespace {

using Narrow = std::uint8_t __attribute__((vector_size(8)));
using Wide = std::uint32_t __attribute__((vector_size(32)));

struct Sums {
  std::uint64_t low, high;
};

// Adler-32 is (low, high) with low = 1 + the bytes' sum and high = the sum of all values that low takes, modulo 65521.
// So the byte at i counts n - i times in high. In rows of 32 bytes, n - i = 32 (rows - r) - j, and adding the columns'
// sums up row by row counts the byte of row r just rows - r times. Sums stay below 2^32: 255 x 2048 x 2049 / 2.
template <bool copied>
[[gnu::always_inline]] inline Sums sums_of(std::span<const std::byte> bytes, std::byte* to) {
  constexpr std::size_t width = 32, parts = 4;
  std::array<Wide, parts> sums{}, sums_of_sums{};
  const std::size_t rows = bytes.size() / width;
  const std::byte* row = bytes.data();
  for (std::size_t r = 0; r < rows; ++r, row += width) {
    if constexpr (copied) std::memcpy(to + r * width, row, width);
    for (std::size_t p = 0; p < parts; ++p) {
      Narrow narrow;
      std::memcpy(&narrow, row + p * sizeof narrow, sizeof narrow);
      sums[p] += __builtin_convertvector(narrow, Wide);
      sums_of_sums[p] += sums[p];
    }
  }
  Sums all{0, 0};
  for (std::size_t j = 0; j < width; ++j) {
    const std::uint64_t sum = sums[j / 8][j % 8];
    all.low += sum;
    all.high += width * std::uint64_t{sums_of_sums[j / 8][j % 8]} - j * sum;
  }
  for (std::size_t i = rows * width; i < bytes.size(); ++i) {
    if constexpr (copied) to[i] = bytes[i];
    all.low += static_cast<std::uint64_t>(bytes[i]);
    all.high += all.low;
  }
  return all;
}

template <bool copied>
Sums plain(std::span<const std::byte> bytes, std::byte* to) {
  return sums_of<copied>(bytes, to);
}
#if defined(__x86_64__)
template <bool copied>
[[gnu::target("avx2")]] Sums avx2(std::span<const std::byte> bytes, std::byte* to) {
  return sums_of<copied>(bytes, to);
}
template <bool copied>
Sums choose(std::span<const std::byte> bytes, std::byte* to) {
  return __builtin_cpu_supports("avx2") ? avx2<copied>(bytes, to) : plain<copied>(bytes, to);
}
#else
template <bool copied>
Sums choose(std::span<const std::byte> bytes, std::byte* to) {
  return plain<copied>(bytes, to);
}
#endif

void extend(std::uint32_t& low, std::uint32_t& high, std::size_t size, const Sums& sums) {
  constexpr std::uint64_t modulus = 65521;
  high = static_cast<std::uint32_t>((high + size * std::uint64_t{low} + sums.high) % modulus);
  low = static_cast<std::uint32_t>((low + sums.low) % modulus);
}

}  // namespace

void BlockSum::add(std::span<const std::byte> bytes) {
  extend(low_, high_, bytes.size(), choose<false>(bytes, nullptr));
}

void BlockSum::copy(std::span<const std::byte> bytes, std::byte* to) {
  extend(low_, high_, bytes.size(), choose<true>(bytes, to));
}

}  // namespace tessera::store
