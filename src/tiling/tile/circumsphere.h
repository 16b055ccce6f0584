// Filters on circumspheres, computed in floating point with a rigorous error bound, so that rounding can cost time but
// never correctness.
#pragma once

#include <array>

#include "src/base/point.h"

namespace tessera {

// A ball that contains the true circumsphere. If it is not known, the sphere counts as all of space.
struct Ball {
  bool known = false;
  Point center;
  double radius = 0;  // every point of the true sphere is within this distance of `center`
};

// Returns the ball of a tetrahedron. The error bound is derived in circumsphere.cc.
Ball circumsphere(const Point& a, const Point& b, const Point& c, const Point& d);
// Returns the ball of a triangle in the xy plane (z is 0).
Ball circumcircle(const Point& a, const Point& b, const Point& c);

// Returns true only if the circumsphere lies strictly inside the box (in 2D z is ignored).
bool surely_inside(const Ball& ball, const Box& box, int dimension);

}  // namespace tessera
