// Random directions.
#pragma once

#include <cmath>

#include "src/base/point.h"
#include "src/base/random.h"

namespace tessera {

// A direction, evenly distributed. Marsaglia 1972: turns an even distribution in the disc into one on the sphere. In 2D
// the directions of the disc serve.
inline Point direction(Random& random, int dimension) {
  double u = 0, v = 0, s = 0;
  do {
    u = random.between(-1, 1);
    v = random.between(-1, 1);
    s = u * u + v * v;
  } while (s >= 1 || s < 1e-6);
  if (dimension == 2) return {u / std::sqrt(s), v / std::sqrt(s), 0};
  const double factor = 2 * std::sqrt(1 - s);
  return {u * factor, v * factor, 1 - 2 * s};
}

}  // namespace tessera
