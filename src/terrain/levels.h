// The heights of contour lines.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace tessera::terrain {

// Level k is base + k * interval, rounded once.
struct Levels {
  double interval = 1;  // above 0
  double base = 0;

  // Of heights beyond base by more intervals than this, two levels might be one double.
  static constexpr double number_max = 0x1p40;

  double height(std::int64_t k) const { return std::fma(static_cast<double>(k), interval, base); }
  // The first level above z. REQUIRES: z is finite, and within number_max levels.
  std::int64_t above(double z) const {
    auto k = static_cast<std::int64_t>(std::floor((z - base) / interval));
    while (height(k) > z) --k;
    while (height(k) <= z) ++k;
    return k;
  }
};

}  // namespace tessera::terrain
