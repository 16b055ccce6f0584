// The predicates of the flat kernel: filters on differences to the query, then exact, then the perturbation. The error
// bounds are those derived in src/geometry/predicates/exact/predicates.h; the determinants are written so that the
// kernel's vector code and this agree.
#pragma once

#include <algorithm>
#include <cmath>

#include "src/base/point.h"
#include "src/geometry/predicates/exact/predicates.h"

namespace tessera::flat3 {

inline constexpr double orientation_error = 50 * exact::filter::u, in_sphere_error = 400 * exact::filter::u;
inline constexpr double underflow = exact::filter::underflow;

// As exact::orientation_3, with a filter on differences to the first point.
inline int orientation_3(const Point& p, const Point& a, const Point& b, const Point& c) {
  return -exact::orientation_3(a, b, c, p);
}

}  // namespace tessera::flat3
