// The predicates of the proof, on CGAL's: they have the names and meanings of those in src/geometry/predicates/exact,
// with which the engine works, and nothing else in common with them. For every finite double.
#pragma once

#include "src/base/point.h"

namespace tessera::independent {

// The exact sign of the volume of (a, b, c, d), of the area of (a, b, c) in the xy plane when dimension is 2.
int orientation_3(const Point& a, const Point& b, const Point& c, const Point& d);
int orientation_2(const Point& a, const Point& b, const Point& c);
// Whether a, b, c lie on one line, exactly.
bool collinear_3(const Point& a, const Point& b, const Point& c);
// Positive when e is inside the circumsphere of the positively oriented (a, b, c, d), ties broken by the perturbation.
// Never 0 for distinct points that are not all coplanar.
int in_sphere_perturbed_3(const Point& a, const Point& b, const Point& c, const Point& d, const Point& e);
int in_circle_perturbed_2(const Point& a, const Point& b, const Point& c, const Point& d);

}  // namespace tessera::independent
