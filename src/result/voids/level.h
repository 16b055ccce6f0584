// The density of a vertex, in an order without ties.
#pragma once

#include <cmath>

#include "src/base/ids.h"

namespace tessera::voids {

// A lower level is a lower density. `value` is the density, or the Voronoi volume with a minus sign: volumes are
// compared as they are, because their inverses would be rounded to equal densities. Of vertices with equal values the
// one with the lower source index is lower. REQUIRES: value is not NaN.
struct Level {
  double value = 0;
  PointId vertex;

  friend bool operator<(const Level& a, const Level& b) {
    return a.value < b.value || (a.value == b.value && a.vertex < b.vertex);
  }
  friend bool operator==(const Level&, const Level&) = default;
};

// Whether two tiles say the same of a vertex; NaN, outside of all zones, included.
inline bool same_level(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

}  // namespace tessera::voids
