// Finds the grid of doubles that are multiples of a step, such as decimals, LAS coordinates and pixels.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <span>

#include "src/base/ieee_arithmetic.h"
#include "src/result/store/integer_block.h"

namespace tessera::store {

// A scale predicts a double from an integer k: as k / scale, or as k times the double nearest to 1 / scale.
class GridScale {
 public:
  // The scale that files store under this code, from 1 on; nothing for other codes.
  static std::optional<GridScale> of_code(std::uint8_t code);
  std::uint8_t code() const { return code_; }

  // The integer k whose prediction is nearest, |k| <= 2^53; 0 when the value is out of range.
  std::int64_t multiple(double value) const {
    const double v = value * scale_;
    if (!(std::abs(v) < 0x1p53)) return 0;
    return static_cast<std::int64_t>(std::abs(v) < 0x1p52 ? v + std::copysign(0.5, v) : v);
  }
  double prediction(std::int64_t k) const {
    return multiplies_ ? static_cast<double>(k) * step_ : static_cast<double>(k) / scale_;
  }
  bool multiplies() const { return multiplies_; }  // also true for powers of two, where it makes no difference
  double scale() const { return scale_; }
  double step() const { return step_; }

 private:
  GridScale(std::uint8_t code, double scale, bool multiplies)
      : scale_(scale), step_(1 / scale), code_(code), multiplies_(multiplies) {}
  friend class GridFinder;
  double scale_, step_;
  std::uint8_t code_;
  bool multiplies_;
};

// Tries one scale after the other, the smallest first.
class GridFinder {
 public:
  // The next scale whose predictions of all values are right, or so nearly right that this is no accident. Values that
  // are not finite, or too large for any scale, are ignored. Nothing when there is no such scale, or all values are
  // ignored.
  std::optional<GridScale> next(std::span<const double> values);
  static bool counts(double value) { return value > -0x1p53 && value < 0x1p53; }

 private:
  std::size_t next_ = 0;
};

// Maps the bits of doubles to numbers with the same order, and back. -0 comes before +0, and NaNs are at both ends.
constexpr std::uint64_t ordered(std::uint64_t bits) { return bits ^ (sign_of(bits) | std::uint64_t{1} << 63u); }
constexpr std::uint64_t unordered(std::uint64_t number) {
  return number ^ (~sign_of(number) | std::uint64_t{1} << 63u);
}

}  // namespace tessera::store
