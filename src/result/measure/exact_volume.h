// Exact volumes of cells. A double is an integer times a power of two, and so is a determinant of doubles.
//
// The integers are Boost.Multiprecision's. An exact sum does not depend on the order of its terms. So a sum over cells
// is the same however cells are divided into tiles, and however many threads add them; it is rounded once. The idea is
// from Kulisch, Miranker, The arithmetic of the digital computer, SIAM Review 28 (1986). Their accumulator has one
// fixed exponent; here the exponent is the least one that was added.
#pragma once

#include <array>
#include <boost/multiprecision/cpp_int.hpp>
#include <cstddef>
#include <span>

#include "src/base/point.h"
#include "src/result/measure/scaled_double.h"

namespace tessera {

// Of any size; 512 bits need no memory of their own, and are enough for nearly all volumes.
using Integer = boost::multiprecision::number<boost::multiprecision::cpp_int_backend<512, 0>>;

// The number value times 2^exponent.
struct ScaledInteger {
  Integer value;
  int exponent = 0;
};

// Returns d! times the signed volume of a simplex of d + 1 points; in 2D twice the area of the triangle in the plane.
// Positive when det(p1-p0, p2-p0[, p3-p0]) is positive. REQUIRES: 3 or 4 finite points.
ScaledInteger volume_times_factorial(std::span<const Point> corners);

// number / divisor, rounded to the nearest double, ties to even; infinite when it is too large for a double.
double rounded_quotient(const ScaledInteger& number, unsigned divisor);

// The same with any exponent; right to the last bit but one.
ScaledDouble scaled_quotient(const ScaledInteger& number, unsigned divisor);

class ExactSum {
 public:
  void add(const ScaledInteger& number);
  void add(const ExactSum& other) { add(other.sum_); }
  const ScaledInteger& value() const { return sum_; }

 private:
  ScaledInteger sum_;
};

}  // namespace tessera
