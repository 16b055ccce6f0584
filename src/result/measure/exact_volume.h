// Volumes of cells, exactly: a double is an integer times a power of two, and so is a determinant of doubles.
//
// The integers are those of Boost.Multiprecision. An exact sum does not depend on the order of what is added, so sums
// over cells are the same however cells are cut into tiles, and by how many threads they are added; they are rounded
// once. Source of the idea: Kulisch, Miranker, The arithmetic of the digital computer, SIAM Review 28 (1986), whose
// accumulator has one fixed exponent for all; here the exponent is the least that was added.
#pragma once

#include <array>
#include <boost/multiprecision/cpp_int.hpp>
#include <cstddef>
#include <span>

#include "src/base/point.h"

namespace tessera {

// value times 2^exponent.
struct ScaledInteger {
  boost::multiprecision::cpp_int value;
  int exponent = 0;
};

// d! times the signed volume of a simplex of d + 1 points, in 2D twice the area of the triangle in the plane. Positive
// when det(p1-p0, p2-p0[, p3-p0]) is. REQUIRES: 3 or 4 finite points.
ScaledInteger volume_times_factorial(std::span<const Point> corners);

// number / divisor, rounded to the nearest double, ties to even; infinite when it is beyond the largest.
double rounded_quotient(const ScaledInteger& number, unsigned divisor);

class ExactSum {
 public:
  void add(const ScaledInteger& number);
  void add(const ExactSum& other) { add(other.sum_); }
  const ScaledInteger& value() const { return sum_; }

 private:
  ScaledInteger sum_;
};

}  // namespace tessera
