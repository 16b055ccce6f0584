// The yardstick: CGAL's own sequential triangulation of all points, as its users call it.
#pragma once

#include <vector>

#include "src/base/point.h"

namespace tessera {

struct CgalTime {
  double seconds = 0;  // the triangulation alone: points are in memory, nothing is written
  std::size_t cells = 0;
};
CgalTime cgal_sequential(const std::vector<Point>& points, int dimension);

}  // namespace tessera
