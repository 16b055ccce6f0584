// The corners of a box.
#pragma once

#include <array>
#include <cstddef>

#include "src/base/point.h"

namespace tessera {

class Corners {
 public:
  const Point* begin() const { return points_.data(); }
  const Point* end() const { return points_.data() + size_; }

 private:
  friend Corners corners_of(const Bounds& box, int dimension);
  std::array<Point, 8> points_{};
  std::size_t size_ = 0;
};

// Returns four corners in 2D, with z = 0, or eight in 3D.
inline Corners corners_of(const Bounds& box, int dimension) {
  Corners corners;
  corners.size_ = dimension == 2 ? 4 : 8;
  for (std::size_t i = 0; i < corners.size_; ++i) {
    Point& p = corners.points_[i];
    for (int axis = 0; axis < dimension; ++axis) p[axis] = (i >> axis & 1) != 0 ? box.hi[axis] : box.lo[axis];
  }
  return corners;
}

}  // namespace tessera
