// Exact numbers of Voronoi diagrams. A double is an integer times a power of two, and a Voronoi vertex is a quotient of
// such integers. A vertex is rounded once, to the nearest double. So every cell, facet and tile that computes the same
// vertex gets the same bits, whichever of its points the vertex is computed from.
#pragma once

#include <boost/multiprecision/cpp_int.hpp>
#include <memory>
#include <span>

#include "src/base/point.h"

namespace tessera::voronoi {

// Of any length; up to 512 bits without an allocation.
using Whole =
    boost::multiprecision::number<boost::multiprecision::cpp_int_backend<
                                      512, 0, boost::multiprecision::signed_magnitude, boost::multiprecision::unchecked,
                                      std::allocator<boost::multiprecision::limb_type>>,
                                  boost::multiprecision::et_off>;

inline int sign_of(const Whole& number) { return number.sign(); }

// The exponent of 0, which is a multiple of every power of two.
inline constexpr int no_exponent = 4096;
// The greatest e such that x is a multiple of 2^e. REQUIRES: x is finite.
int exponent_of(double x);
// x / 2^exponent. REQUIRES: x is finite and a multiple of 2^exponent.
Whole whole_of(double x, int exponent);
// number / divisor * 2^exponent, rounded to the nearest double, ties to even; infinite when it is too large for a
// double. REQUIRES: the divisor is not 0.
double rounded(const Whole& number, const Whole& divisor, int exponent);

// The circumcentre of 3 points in the plane (z = 0) or of 4 points in space, each coordinate correctly rounded.
// REQUIRES: the points are finite and not flat.
Point circumcentre(std::span<const Point> corners);

}  // namespace tessera::voronoi
