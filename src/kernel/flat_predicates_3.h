// The predicates of the flat kernel: filters on differences to the query, then exact, then the perturbation. The error
// bounds are those derived in exact_predicates.h; the determinants are written so that the kernel's vector code and
// this agree.
#pragma once

#include <algorithm>
#include <cmath>

#include "src/base/point.h"
#include "src/kernel/exact_predicates.h"

namespace tessera::flat3 {

inline constexpr double orientation_error = 50 * exact::filter::u, in_sphere_error = 400 * exact::filter::u;
inline constexpr double underflow = exact::filter::underflow;

// The sign of the volume of (p, a, b, c).
inline int orientation(const Point& p, const Point& a, const Point& b, const Point& c) {
  return -exact::orient3(a, b, c, p);
}

// Positive when e is inside the sphere of the positive cell (a, b, c, d); never 0 for distinct points. For what a
// filter could not tell.
inline int in_sphere(const Point& a, const Point& b, const Point& c, const Point& d, const Point& e) {
  return exact::insphere_perturbed(a, b, c, d, e);
}

}  // namespace tessera::flat3
