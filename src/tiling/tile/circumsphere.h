// Filters on circumspheres: computed in floating point with a rigorous error bound, so that rounding can cost time,
// never truth.
#pragma once

#include <array>

#include "src/base/point.h"

namespace tessera {

// A ball that contains the true circumsphere, or nothing is known of it (then it counts as all of space).
struct Ball {
  bool known = false;
  Point center;
  double reach = 0;  // the true sphere lies within this distance of `center`, on every axis and in all
};

// Of a tetrahedron. Error bound in circumsphere.cc.
Ball circumsphere(const Point& a, const Point& b, const Point& c, const Point& d);
// Of a triangle in the xy plane (z is 0).
Ball circumcircle(const Point& a, const Point& b, const Point& c);

// True only if the circumsphere lies strictly inside the box (in 2D pass a box unbounded in z).
bool surely_inside(const Ball& ball, const Box& box, int dimension);

}  // namespace tessera
