// Places on the sky as Cartesian coordinates.
#pragma once

#include "src/base/point.h"

namespace tessera::fits {

// The point at a right ascension and a declination, in degrees, and a distance: x points to (0, 0), y to (90, 0), and z
// to the declination 90. The error of a coordinate is below 1e-15 of the distance, and the bits are the same on every
// machine: sines of C libraries differ in the last one. NaN for a declination that is not between -90 and 90, a
// distance that is negative, and numbers that are not finite.
Point place_on_sky(double right_ascension, double declination, double distance);

}  // namespace tessera::fits
