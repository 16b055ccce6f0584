// How far apart points are, roughly. For heuristics only.
#pragma once

#include <cmath>
#include <cstddef>

#include "src/base/point.h"

namespace tessera {

// Returns the distance between neighbours if n points filled their bounds evenly.
inline double even_spacing(const Bounds& bounds, std::size_t n, int dimension) {
  double volume = 1;
  for (int i = 0; i < dimension; ++i) volume *= bounds.hi[i] - bounds.lo[i];
  return std::pow(volume / static_cast<double>(n + 1), 1.0 / dimension);
}

}  // namespace tessera
