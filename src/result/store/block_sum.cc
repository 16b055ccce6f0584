#include "src/result/store/block_sum.h"

#include <algorithm>
#include <array>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace tessera::store {
namespace {

struct Sums {
  std::uint64_t low, high;
};

// Adler-32 is (low, high): low = 1 + the sum of the bytes, and high = the sum of all values that low takes, modulo
// 65521. So the byte at i counts n - i times in high.
void add_singly(Sums& sums, std::span<const std::byte> bytes) {
  for (const std::byte b : bytes) {
    sums.low += static_cast<std::uint64_t>(b);
    sums.high += sums.low;
  }
}

Sums plain(std::span<const std::byte> bytes) {
  Sums sums{0, 0};
  add_singly(sums, bytes);
  return sums;
}

#if defined(__x86_64__)
// In rows of 32 bytes, n - i = 32 (rows - 1 - r) + (32 - j). So the sum of all rows before each row counts 32 times,
// and each byte counts by its place in the row. Sums stay below 2^31: 255 x 16320 x 2048 at most.
template <bool copied>
[[gnu::target("avx2")]] Sums avx2(std::span<const std::byte> bytes, std::byte* to) {
  constexpr std::size_t width = 32;
  const __m256i zero = _mm256_setzero_si256(), ones = _mm256_set1_epi16(1);
  const __m256i weights = _mm256_setr_epi8(32, 31, 30, 29, 28, 27, 26, 25, 24, 23, 22, 21, 20, 19, 18, 17, 16, 15, 14,
                                           13, 12, 11, 10, 9, 8, 7, 6, 5, 4, 3, 2, 1);
  __m256i sum = zero, before = zero, placed = zero;
  const std::size_t rows = bytes.size() / width;
  for (std::size_t r = 0; r < rows; ++r) {
    const __m256i row = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(bytes.data() + r * width));
    if constexpr (copied) _mm256_storeu_si256(reinterpret_cast<__m256i*>(to + r * width), row);
    before = _mm256_add_epi64(before, sum);
    sum = _mm256_add_epi64(sum, _mm256_sad_epu8(row, zero));
    placed = _mm256_add_epi32(placed, _mm256_madd_epi16(_mm256_maddubs_epi16(row, weights), ones));
  }
  std::array<std::uint64_t, 4> sums, befores;
  std::array<std::uint32_t, 8> places;
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(sums.data()), sum);
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(befores.data()), before);
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(places.data()), placed);
  Sums all{0, 0};
  for (const std::uint64_t s : sums) all.low += s;
  for (const std::uint64_t b : befores) all.high += width * b;
  for (const std::uint32_t p : places) all.high += p;
  const auto rest = bytes.subspan(rows * width);
  if constexpr (copied) std::copy(rest.begin(), rest.end(), to + rows * width);
  add_singly(all, rest);
  return all;
}
#endif

Sums sums_of(std::span<const std::byte> bytes) {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) return avx2<false>(bytes, nullptr);
#endif
  return plain(bytes);
}

Sums copied_sums_of(std::span<const std::byte> bytes, std::byte* to) {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) return avx2<true>(bytes, to);
#endif
  std::copy(bytes.begin(), bytes.end(), to);
  return plain(bytes);
}

void extend(std::uint32_t& low, std::uint32_t& high, std::size_t size, const Sums& sums) {
  constexpr std::uint64_t modulus = 65521;
  high = static_cast<std::uint32_t>((high + size * std::uint64_t{low} + sums.high) % modulus);
  low = static_cast<std::uint32_t>((low + sums.low) % modulus);
}

}  // namespace

void BlockChecksum::add(std::span<const std::byte> bytes) { extend(low_, high_, bytes.size(), sums_of(bytes)); }

void BlockChecksum::copy(std::span<const std::byte> bytes, std::byte* to) {
  extend(low_, high_, bytes.size(), copied_sums_of(bytes, to));
}

}  // namespace tessera::store
