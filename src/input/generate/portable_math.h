// Sine and logarithm from additions, multiplications and divisions alone. IEEE defines these to the last bit, but each
// C library rounds its own sin and log. So a generated cloud is the same on every machine.
#pragma once

#include <cmath>

namespace tessera {

// sin(2 pi turns), with an error below 1e-15. A Taylor polynomial to x^21 on a quarter turn.
inline double sine_of_turns(double turns) {
  double r = turns - std::floor(turns + 0.5);
  if (r > 0.25) r = 0.5 - r;
  if (r < -0.25) r = -0.5 - r;
  const double x = 6.283185307179586 * r, xx = x * x;
  double sum = 1;
  for (int k = 20; k >= 2; k -= 2) sum = 1 - xx / (k * (k + 1)) * sum;
  return x * sum;
}

// The natural logarithm of a normal v > 0, with a relative error below 1e-15. v = m 2^e, log m = 2 artanh((m - 1) / (m
// + 1)).
inline double portable_log(double v) {
  int exponent = 0;
  double m = std::frexp(v, &exponent);
  if (m < 0.7071067811865476) {
    m *= 2;
    --exponent;
  }
  const double f = (m - 1) / (m + 1), ff = f * f;
  double sum = 0;
  for (int k = 21; k >= 1; k -= 2) sum = sum * ff + 1.0 / k;
  return 2 * f * sum + exponent * 0.6931471805599453;
}

}  // namespace tessera
