// The heights of contour lines.
#pragma once

#include <cmath>
#include <cstdint>

namespace tessera::terrain {

// Level k is base + k * interval, computed from the decimals for which these doubles stand, and rounded once. So a
// height that a file gives as 0.3 is at the third level of 0.1, which the product of the doubles would miss.
class Levels {
 public:
  // REQUIRES: both are finite, and the interval is above 0.
  Levels(double interval, double base) : interval_(interval), base_(base) {
    constexpr double integers_max = 0x1p53;
    for (double parts = 1; parts <= 1e15; parts *= 10) {
      const double step = std::round(interval * parts), first = std::round(base * parts);
      if (step > integers_max || std::abs(first) > integers_max) break;
      if (step / parts != interval || first / parts != base) continue;
      parts_ = parts;
      step_ = step;
      first_ = first;
      break;
    }
  }

  // For heights further from base than this many intervals, two levels might be the same double.
  static constexpr double number_max = 0x1p40;

  double interval() const { return interval_; }
  double base() const { return base_; }
  double height(std::int64_t k) const {
    const auto number = static_cast<double>(k);
    return parts_ > 0 ? std::fma(number, step_, first_) / parts_ : std::fma(number, interval_, base_);
  }
  // The first level above z. REQUIRES: z is finite and within number_max levels.
  std::int64_t above(double z) const {
    auto k = static_cast<std::int64_t>(std::floor((z - base_) / interval_));
    while (height(k) > z) --k;
    while (height(k) <= z) ++k;
    return k;
  }

 private:
  double interval_, base_;
  // Both as integers in units of 1 / parts_, a power of ten; 0: they are not short decimals.
  double parts_ = 0, step_ = 0, first_ = 0;
};

}  // namespace tessera::terrain
