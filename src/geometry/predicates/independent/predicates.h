// The predicates of `tessera verify`, written on CGAL's predicates. Their names and meanings are those of
// src/geometry/predicates/exact, which the engine uses. The two folders share no code. The predicates are right for
// every finite double.
#pragma once

#include "src/base/point.h"

namespace tessera::independent {

// The exact sign of the volume of (a, b, c, d), or of the area of (a, b, c) in the xy plane.
int orientation_3(const Point& a, const Point& b, const Point& c, const Point& d);
int orientation_2(const Point& a, const Point& b, const Point& c);
// Whether a, b and c lie exactly on one line.
bool collinear_3(const Point& a, const Point& b, const Point& c);
// Positive when the last point is inside the circumsphere, or circumcircle, of the positively oriented cell of the
// other points. The perturbation breaks ties. Never 0 for distinct points that are not all coplanar, or collinear in
// 2D.
int in_sphere_perturbed_3(const Point& a, const Point& b, const Point& c, const Point& d, const Point& e);
int in_circle_perturbed_2(const Point& a, const Point& b, const Point& c, const Point& d);

}  // namespace tessera::independent
