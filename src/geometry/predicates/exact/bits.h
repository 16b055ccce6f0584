// Doubles as integers times a power of two.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "src/geometry/predicates/exact/integer.h"

namespace tessera::exact {

// A finite double as magnitude * 2^exponent, with a sign. The magnitude is odd unless the double is 0.
struct Parts {
  std::uint64_t magnitude = 0;
  int exponent = 0;
  bool negative = false;
  explicit Parts(double v) {
    const auto bits = std::bit_cast<std::uint64_t>(v);
    const int field = static_cast<int>(bits >> 52 & 0x7ff);
    negative = bits >> 63;
    magnitude = (bits & ((std::uint64_t{1} << 52) - 1)) | (std::uint64_t{field != 0} << 52);
    if (magnitude == 0) return;
    const int zeros = std::countr_zero(magnitude);
    magnitude >>= zeros;
    exponent = std::max(field, 1) - 1075 + zeros;
  }
  int end() const { return exponent + std::bit_width(magnitude); }  // |v| < 2^end
};

// The bits that a set of doubles spans: all values are multiples of 2^low and smaller than 2^high in absolute value.
struct BitRange {
  int low = 5000, high = -5000;
  template <std::size_t N>
  explicit BitRange(const std::array<double, N>& values) {
    for (const double v : values) {
      const Parts p(v);
      if (p.magnitude == 0) continue;
      low = std::min(low, p.exponent);
      high = std::max(high, p.end());
    }
  }
  int bits() const { return high - low; }  // negative when all values are 0
};

// Sets `to` to v * 2^-low. REQUIRES: v is a multiple of 2^low, `to` is 0, and the value fits.
inline void scale(double v, int low, Integer<1>& to) {
  const Parts p(v);
  if (p.magnitude == 0) return;
  const std::uint64_t m = p.magnitude << (p.exponent - low);
  to.limb[0] = p.negative ? 0 - m : m;
}

inline void scale(double v, int low, Integer<2>& to) {
  const Parts p(v);
  if (p.magnitude == 0) return;
  Wide m = Wide{p.magnitude} << (p.exponent - low);
  if (p.negative) m = 0 - m;
  to.limb = {static_cast<std::uint64_t>(m), static_cast<std::uint64_t>(m >> 64)};
}

}  // namespace tessera::exact
