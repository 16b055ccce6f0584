// Measures of the shape of a cell, for meshers.
//
// The radius ratio is d times the radius of the inscribed sphere, divided by the radius of the circumsphere: 1 for a
// regular simplex, and near 0 for a flat one (Liu, Joe, On the shape of tetrahedra from bisection, Mathematics of
// Computation 63 (1994)). Angles are those of a triangle at its corners, and of a tetrahedron at its edges.
#pragma once

#include <span>

#include "src/base/point.h"
#include "src/result/measure/exact_volume.h"

namespace tessera {

struct CellQuality {
  double radius_ratio = 0;                    // from 0 to 1
  double least_angle = 0, largest_angle = 0;  // in degrees; in 3D dihedral angles
  double circumradius = 0;                    // in units of the coordinates; infinite when too large for a double
};

// `exact` is volume_times_factorial(corners), which keeps flat cells from being measured by rounding errors. The result
// depends on the order of the corners in the last bits. REQUIRES: 3 or 4 finite points, in 2D with z = 0; the volume is
// not 0.
CellQuality quality_of(std::span<const Point> corners, const ScaledInteger& exact);

}  // namespace tessera
