// Circumradii of cells and of their faces, compared exactly with a double, for every finite double.
//
// The simplices are edges, triangles and tetrahedra. The circumradius of a simplex of fewer corners than a cell is the
// radius of the smallest circle or sphere through the corners; its centre is in the line or plane of the corners.
// Floating point with an error bound decides first. Integers of any length decide where the bound is too large for
// that. Functions with `flat` read x and y only. All functions are safe to call from any thread.
#pragma once

#include <span>

#include "src/base/point.h"

namespace tessera::exact {

// The sign of (circumradius - radius). The circumradius of collinear or coplanar corners is larger than any radius.
// REQUIRES: 2 to 4 corners, in 2D at most 3; radius is finite and at least 0.
int compare_circumradius(std::span<const Point> corners, bool flat, double radius);

// The least double that is not less than the circumradius: a double is at least the circumradius exactly when the
// double is at least this value. Infinite when no finite double is. REQUIRES: as compare_circumradius().
double circumradius_up(std::span<const Point> corners, bool flat);

// Whether `other` is strictly inside the smallest circle or sphere through the corners. REQUIRES: 2 corners, or in 3D
// 2 or 3 corners that are not collinear.
bool in_smallest_sphere(std::span<const Point> corners, const Point& other, bool flat);

}  // namespace tessera::exact
