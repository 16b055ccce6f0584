#include "src/input/fits/sky.h"

#include <cmath>
#include <limits>
#include <utility>

namespace tessera::fits {
namespace {

struct SineCosine {
  double sine, cosine;
};

// Of an angle in degrees. The angle is reduced to at most 45 degrees without rounding; there Taylor polynomials of
// degree 17 and 18 have errors below 1e-19.
SineCosine of_degrees(double degrees) {
  int quarter = 0;
  const double rest = std::remquo(degrees, 90, &quarter);
  constexpr double radians_of_degree = 0.017453292519943295769;
  const double x = rest * radians_of_degree, xx = x * x;
  double sine = 1, cosine = 1;
  for (int k = 16; k >= 2; k -= 2) sine = 1 - xx / (k * (k + 1)) * sine;
  for (int k = 17; k >= 1; k -= 2) cosine = 1 - xx / (k * (k + 1)) * cosine;
  sine *= x;
  // remquo() gives the last three bits of the quotient, and its sign.
  switch (((quarter % 4) + 4) % 4) {
    case 0:
      return {sine, cosine};
    case 1:
      return {cosine, -sine};
    case 2:
      return {-sine, -cosine};
    default:
      return {-cosine, sine};
  }
}

}  // namespace

Point place_on_sky(double right_ascension, double declination, double distance) {
  const double unknown = std::numeric_limits<double>::quiet_NaN();
  const bool valid = std::isfinite(right_ascension) && declination >= -90 && declination <= 90 && distance >= 0 &&
                     std::isfinite(distance);
  if (!valid) return {unknown, unknown, unknown};
  const SineCosine around = of_degrees(right_ascension), up = of_degrees(declination);
  return {distance * up.cosine * around.cosine, distance * up.cosine * around.sine, distance * up.sine};
}

}  // namespace tessera::fits
