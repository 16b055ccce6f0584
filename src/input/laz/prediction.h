// Predictions for the decoders of all point formats: the median of recent differences, and tables by return number and
// number of returns. Source: rapidlasso, LAZ Specification 1.4, and LASzip's design/specification.rst.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>

namespace tessera::laz {

// Approximates the median of the last five numbers. A new number replaces the largest or the smallest of five sorted
// numbers. The choice between largest and smallest changes only when the new number lies in the half that is kept.
class RunningMedian {
 public:
  std::int32_t value() const { return sorted_[2]; }

  void add(std::int32_t v) {
    auto& s = sorted_;
    if (drop_largest_) {
      drop_largest_ = v < s[2];
      s[4] = v < s[3] ? s[3] : v;
      s[3] = v < s[3] ? std::max(v, s[2]) : s[3];
      if (v < s[2]) {
        s[2] = std::max(v, s[1]);
        s[1] = std::min(s[1], std::max(v, s[0]));
        s[0] = std::min(v, s[0]);
      }
    } else {
      drop_largest_ = v <= s[2];
      s[0] = v > s[1] ? s[1] : v;
      s[1] = v > s[1] ? std::min(v, s[2]) : s[1];
      if (v > s[2]) {
        s[2] = std::min(v, s[3]);
        s[3] = std::max(s[3], std::min(v, s[4]));
        s[4] = std::max(v, s[4]);
      }
    }
  }

 private:
  std::array<std::int32_t, 5> sorted_{};
  bool drop_largest_ = true;
};

// A kind of return for formats 0-3, by the number of returns and the return number.
inline constexpr std::uint8_t return_kind_3bit[8][8] = {
    {15, 14, 13, 12, 11, 10, 9, 8},  {14, 0, 1, 3, 6, 10, 10, 9},   {13, 1, 2, 4, 7, 11, 11, 10},
    {12, 3, 4, 5, 8, 12, 12, 11},    {11, 6, 7, 8, 9, 13, 13, 12},  {10, 10, 11, 12, 13, 14, 14, 13},
    {9, 10, 11, 12, 13, 14, 15, 14}, {8, 9, 10, 11, 12, 13, 14, 15}};

// The same for formats 6-8, with six kinds.
inline constexpr std::uint8_t return_kind_4bit[16][16] = {
    {0, 1, 2, 3, 4, 5, 3, 4, 4, 5, 5, 5, 5, 5, 5, 5}, {1, 0, 1, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3},
    {2, 1, 2, 4, 4, 4, 4, 4, 4, 4, 4, 3, 3, 3, 3, 3}, {3, 3, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4},
    {4, 3, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4}, {5, 3, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4},
    {3, 3, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4, 4}, {4, 3, 4, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4},
    {4, 3, 4, 4, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4}, {5, 3, 4, 4, 4, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4},
    {5, 3, 4, 4, 4, 4, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4}, {5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 4, 4, 4},
    {5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5, 4, 4}, {5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5, 4},
    {5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5}, {5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5}};

// The number of returns of the pulse after this one, or before it if its number is too large; at most 7.
inline std::uint32_t return_level(std::uint32_t returns, std::uint32_t number) {
  return std::min<std::uint32_t>(7, returns > number ? returns - number : number - returns);
}

// Sums and products modulo 2^32 or 2^64. A file may make them overflow, which must not be undefined behaviour.
inline std::int32_t wrapping_add(std::int32_t a, std::int32_t b) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(a) + static_cast<std::uint32_t>(b));
}
inline std::int32_t wrapping_multiply(std::int32_t a, std::int32_t b) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(a) * static_cast<std::uint32_t>(b));
}
inline std::int64_t wrapping_add(std::int64_t a, std::int64_t b) {
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(a) + static_cast<std::uint64_t>(b));
}

// The context of y given the length of x's correction, or of z given the mean length of both: in steps of two, at most
// `most`.
inline std::uint32_t length_context(std::uint32_t length, std::uint32_t most, bool single_return) {
  return (length < most ? length & ~1u : most) + single_return;
}

}  // namespace tessera::laz
