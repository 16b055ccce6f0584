// Numbers of any size: volumes of tiny cells and of far outliers are beyond the exponents of a double.
#pragma once

#include <cmath>

namespace tessera {

// The number fraction * 2^exponent. The absolute value of the fraction is 0, or at least 1/2 and below 1.
struct ScaledDouble {
  double fraction = 0;
  int exponent = 0;

  // number * 2^exponent. REQUIRES: number is finite.
  static ScaledDouble of(double number, int exponent = 0) {
    ScaledDouble made;
    made.fraction = std::frexp(number, &made.exponent);
    made.exponent = made.fraction == 0 ? 0 : made.exponent + exponent;
    return made;
  }
  // Infinite when it is too large for a double.
  double value() const { return std::ldexp(fraction, exponent); }
  friend ScaledDouble operator*(const ScaledDouble& a, const ScaledDouble& b) {
    return of(a.fraction * b.fraction, a.exponent + b.exponent);
  }
  // REQUIRES: b is not 0.
  friend ScaledDouble operator/(const ScaledDouble& a, const ScaledDouble& b) {
    return of(a.fraction / b.fraction, a.exponent - b.exponent);
  }
};

}  // namespace tessera
