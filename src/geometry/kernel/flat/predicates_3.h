// The predicates of the flat kernel in 3D: filters on differences to the query, then exact stages, then the
// perturbation. src/geometry/predicates/exact/predicates.h derives the error bounds. The determinants are written so
// that the kernel's vector code gives the same values.
#pragma once

#include <algorithm>
#include <cmath>

#include "src/base/point.h"
#include "src/geometry/predicates/exact/predicates.h"

namespace tessera::flat3 {

inline constexpr double orientation_error = 50 * exact::filter::u, in_sphere_error = 400 * exact::filter::u;
inline constexpr double underflow = exact::filter::underflow;

// Equals exact::orientation_3(p, a, b, c), but its filter uses differences to p.
inline int orientation_3(const Point& p, const Point& a, const Point& b, const Point& c) {
  return -exact::orientation_3(a, b, c, p);
}

}  // namespace tessera::flat3
