// Doubles that are multiples of a step, as decimals, LAS coordinates and pixels are: which step, and the multiples.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <span>

#include "src/base/ieee_arithmetic.h"
#include "src/result/store/integer_block.h"

namespace tessera::store {

// A double is predicted from an integer k as k / scale, or as k times the double nearest to 1 / scale.
class GridScale {
 public:
  // The number under which files know it, from 1 on; nothing for other numbers.
  static std::optional<GridScale> of_code(std::uint8_t code);
  std::uint8_t code() const { return code_; }

  // The integer whose prediction is nearest; 0 for what is out of reach. |k| <= 2^53.
  std::int64_t multiple(double value) const {
    const double v = value * scale_;
    if (!(std::abs(v) < 0x1p53)) return 0;
    return static_cast<std::int64_t>(std::abs(v) < 0x1p52 ? v + std::copysign(0.5, v) : v);
  }
  double prediction(std::int64_t k) const {
    return multiplies_ ? static_cast<double>(k) * step_ : static_cast<double>(k) / scale_;
  }
  bool multiplies() const { return multiplies_; }  // with powers of two, too: it is the same
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

// Tries one scale after the other, the least first.
class GridFinder {
 public:
  // The next scale all of whose predictions of these values are right, or nearly so and no accident. Values that are
  // not finite, or too large for any, do not count. Nothing when there is none, or no value counts.
  std::optional<GridScale> next(std::span<const double> values);
  static bool counts(double value) { return value > -0x1p53 && value < 0x1p53; }

 private:
  std::size_t next_ = 0;
};

// The bits of doubles as numbers that are ordered as the doubles are, -0 before +0, NaNs at both ends; and back.
constexpr std::uint64_t ordered(std::uint64_t bits) { return bits ^ (sign_of(bits) | std::uint64_t{1} << 63u); }
constexpr std::uint64_t unordered(std::uint64_t number) {
  return number ^ (~sign_of(number) | std::uint64_t{1} << 63u);
}

}  // namespace tessera::store
