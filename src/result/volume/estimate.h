// A number in floating point with a bound on its error (running error analysis: Higham, Accuracy and Stability of
// Numerical Algorithms, section 3.3).
#pragma once

#include <cmath>
#include <limits>

namespace tessera::volume {

// The true number is within `error` of `value`. Bounds are themselves rounded; whoever uses a bound leaves one per
// cent.
struct Estimate {
  static constexpr long double unit = std::numeric_limits<long double>::epsilon();

  long double value = 0, error = 0;

  Estimate() = default;
  explicit Estimate(double exact) : value(exact) {}
  Estimate(long double v, long double e) : value(v), error(e + unit * std::fabs(v)) {}

  friend Estimate operator+(const Estimate& a, const Estimate& b) { return {a.value + b.value, a.error + b.error}; }
  friend Estimate operator-(const Estimate& a, const Estimate& b) { return {a.value - b.value, a.error + b.error}; }
  friend Estimate operator*(const Estimate& a, const Estimate& b) {
    return {a.value * b.value, std::fabs(a.value) * b.error + std::fabs(b.value) * a.error + a.error * b.error};
  }
  friend Estimate operator/(const Estimate& a, const Estimate& b) {
    const long double least = std::fabs(b.value) - b.error;
    if (!(least > 0)) return {0, std::numeric_limits<long double>::infinity()};
    const long double quotient = a.value / b.value;
    return {quotient, (a.error + std::fabs(quotient) * b.error) / least};
  }
  // The sign; 0 if it is not certain.
  int sign() const {
    if (value > 1.01L * error) return 1;
    return value < -1.01L * error ? -1 : 0;
  }
};

}  // namespace tessera::volume
