// With a, b, c for the differences of the corners to the first corner, the square of the circumradius is N / (4 D):
//   edge         N = |a|^2                                        D = 1
//   triangle     N = |a|^2 |b|^2 |a - b|^2                        D = |a x b|^2
//   tetrahedron  N = | |a|^2 b x c + |b|^2 c x a + |c|^2 a x b |^2     D = det(a, b, c)^2
// Source: the circumcentre as in Shewchuk, Lecture notes on geometric robustness, 2013.
#include "src/geometry/predicates/exact/circumradius.h"

#include <algorithm>
#include <array>
#include <bit>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

#include "src/geometry/predicates/exact/bits.h"

namespace tessera::exact {

namespace {

namespace mp = boost::multiprecision;
using mp::cpp_int;

template <class Number>
struct Vector {
  Number x, y, z;
  friend Vector operator+(const Vector& a, const Vector& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Vector operator-(const Vector& a, const Vector& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend Vector operator*(const Number& s, const Vector& a) { return {s * a.x, s * a.y, s * a.z}; }
};

template <class Number>
Number dot(const Vector<Number>& a, const Vector<Number>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class Number>
Vector<Number> cross(const Vector<Number>& a, const Vector<Number>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// Up to three differences to the first corner.
template <class Number>
using Sides = std::array<Vector<Number>, 3>;

template <class Number>
struct Quotient {
  Number numerator, denominator;
};

// N and D as above. `one` is the number 1. `corners` is the number of corners.
template <class Number>
Quotient<Number> squared_radius(const Sides<Number>& side, std::size_t corners, const Number& one) {
  const auto& [a, b, c] = side;
  const Number aa = dot(a, a);
  if (corners == 2) return {aa, one};
  const Number bb = dot(b, b);
  const Vector<Number> ab = cross(a, b);
  if (corners == 3) {
    const Vector<Number> third = a - b;
    return {aa * bb * dot(third, third), dot(ab, ab)};
  }
  const Vector<Number> bc = cross(b, c), centre = aa * bc + bb * cross(c, a) + dot(c, c) * ab;
  const Number det = dot(a, bc);
  return {dot(centre, centre), det * det};
}

// Negative when the last side ends inside the smallest sphere through the corners at 0 and at the ends of the sides
// before it. The centre of the sphere of a triangle is (|b|^2 n x a + |a|^2 b x n) / (2 |n|^2), where n = a x b.
template <class Number>
Number smallest_sphere(const Sides<Number>& side, std::size_t corners) {
  const auto& [a, b, c] = side;
  if (corners == 2) return dot(b, b - a);
  const Vector<Number> n = cross(a, b);
  return dot(c, c) * dot(n, n) - dot(c, dot(b, b) * cross(n, a) + dot(a, a) * cross(b, n));
}

// A floating-point number with the sum of the absolute values of the products that make it up. The error of the value
// is at most k u sum, where u is the rounding unit and k is the number of roundings in the longest chain of operations,
// and the error of underflow. Differences of coordinates, which are rounded once, count as 1 rounding.
//
// Roundings: 5 in a squared length, 4 in a component of a cross product, 12 in a component of `centre`, 27 in its
// squared length; 17 in det^2, 19 times R^2; 28 in the difference of both. 19 in smallest_sphere(). The constant leaves
// a reserve of a quarter for the roundings of the sums themselves.
constexpr int roundings_max = 36;

template <class Float>
struct Filtered {
  Float value = 0, sum = 0;
  friend Filtered operator+(const Filtered& a, const Filtered& b) { return {a.value + b.value, a.sum + b.sum}; }
  friend Filtered operator-(const Filtered& a, const Filtered& b) { return {a.value - b.value, a.sum + b.sum}; }
  friend Filtered operator*(const Filtered& a, const Filtered& b) { return {a.value * b.value, a.sum * b.sum}; }
  // A bound of the relative error; not a number when the value is 0.
  Float error() const { return roundings_max * (std::numeric_limits<Float>::epsilon() / 2) * (sum / std::abs(value)); }
};

// The largest difference is scaled into [1, 2). Then no product of differences exceeds 2^20, and R^2, R at most 1e60,
// enlarges what underflow has lost to less than this.
constexpr double underflow = 1e-150;
constexpr double radius_max = 1e60;

template <class Float>
int sign_of(const Filtered<Float>& number) {
  const Float bound =
      roundings_max * (std::numeric_limits<Float>::epsilon() / 2) * number.sum + static_cast<Float>(underflow);
  return (number.value > bound) - (number.value < -bound);
}

// The sides, scaled by 2^-exponent.
template <class Float>
struct ScaledSides {
  Sides<Filtered<Float>> sides;
  int exponent = 0;
};

// Nothing when the differences are too large or too small to scale them.
template <class Float>
std::optional<ScaledSides<Float>> scaled_sides(std::span<const Point> corners, bool flat) {
  std::array<std::array<Float, 3>, 3> difference{};
  Float largest = 0;
  for (std::size_t i = 1; i < corners.size(); ++i) {
    for (int axis = 0; axis < (flat ? 2 : 3); ++axis) {
      auto& d = difference[i - 1][static_cast<std::size_t>(axis)];
      d = static_cast<Float>(corners[i][axis]) - static_cast<Float>(corners[0][axis]);
      largest = std::max(largest, std::abs(d));
    }
  }
  constexpr int exponent_max = 900;
  if (!(largest > std::ldexp(1.0, -exponent_max) && largest < std::ldexp(1.0, exponent_max))) return std::nullopt;
  ScaledSides<Float> scaled;
  scaled.exponent = std::ilogb(static_cast<double>(largest));
  const Float scale = std::bit_cast<double>(static_cast<std::uint64_t>(1023 - scaled.exponent) << 52);
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    const auto number = [&](std::size_t axis) {
      const Float d = difference[i][axis] * scale;
      return Filtered<Float>{d, std::abs(d)};
    };
    scaled.sides[i] = {number(0), number(1), number(2)};
  }
  return scaled;
}

// The corners and a length, as integers times one power of two.
class Integers {
 public:
  Integers(std::span<const Point> corners, bool flat, double length) {
    for (const Point& p : corners)
      for (int axis = 0; axis < (flat ? 2 : 3); ++axis) lower(p[axis]);
    lower(length);
    low_ = any_ ? low_ : 0;
    length_ = integer(length);
    const auto at = [&](const Point& p) {
      return Vector<cpp_int>{integer(p.x), integer(p.y), flat ? cpp_int(0) : integer(p.z)};
    };
    const Vector<cpp_int> first = at(corners[0]);
    for (std::size_t i = 1; i < corners.size(); ++i) sides_[i - 1] = at(corners[i]) - first;
  }
  const Sides<cpp_int>& sides() const { return sides_; }
  const cpp_int& length() const { return length_; }
  int exponent() const { return low_; }

 private:
  void lower(double v) {
    const Parts parts(v);
    if (parts.magnitude == 0) return;
    low_ = any_ ? std::min(low_, parts.exponent) : parts.exponent;
    any_ = true;
  }
  cpp_int integer(double v) const {
    const Parts parts(v);
    cpp_int value = parts.magnitude;
    if (parts.magnitude == 0) return value;
    value <<= static_cast<unsigned>(parts.exponent - low_);
    return parts.negative ? cpp_int(-value) : value;
  }
  Sides<cpp_int> sides_;
  cpp_int length_;
  int low_ = 0;
  bool any_ = false;
};

int compare_exactly(std::span<const Point> corners, bool flat, double radius) {
  const Integers given(corners, flat, radius);
  const auto [numerator, denominator] = squared_radius(given.sides(), corners.size(), cpp_int(1));
  if (denominator == 0) return 1;
  const cpp_int square = given.length() * given.length();
  return numerator.compare(cpp_int(4 * square * denominator));
}

// The least integer that is not less than number / 2^bits.
cpp_int shifted_up(const cpp_int& number, unsigned bits) {
  if (bits == 0 || number == 0) return number;
  cpp_int shifted = number >> bits;
  if (mp::lsb(number) < bits) ++shifted;
  return shifted;
}

// The least double that is not less than number * 2^exponent.
double double_up(const cpp_int& number, int exponent) {
  if (number == 0) return 0;
  constexpr int digits = std::numeric_limits<double>::digits;
  constexpr int least = std::numeric_limits<double>::min_exponent - digits;
  const int dropped = std::max({static_cast<int>(mp::msb(number)) + 1 - digits, least - exponent, 0});
  const cpp_int kept = shifted_up(number, static_cast<unsigned>(dropped));
  return std::ldexp(static_cast<double>(kept), exponent + dropped);
}

double up_exactly(std::span<const Point> corners, bool flat) {
  const Integers given(corners, flat, 0);
  const auto [numerator, denominator] = squared_radius(given.sides(), corners.size(), cpp_int(1));
  if (denominator == 0) return std::numeric_limits<double>::infinity();
  if (numerator == 0) return 0;
  // An integer m is at least the root of a number exactly when its square is at least that number rounded up. So
  // nothing is lost by rounding up before the root. The shift leaves the root 60 bits or more.
  const cpp_int divisor = 4 * denominator;
  const int length = static_cast<int>(mp::msb(numerator)) - static_cast<int>(mp::msb(divisor));
  const int shift = std::max(0, (122 - length + 1) / 2);
  const cpp_int dividend = numerator << static_cast<unsigned>(2 * shift);
  cpp_int quotient, rest;
  mp::divide_qr(dividend, divisor, quotient, rest);
  if (rest != 0) ++quotient;
  cpp_int left;
  cpp_int root = mp::sqrt(quotient, left);
  if (left != 0) ++root;
  return double_up(root, given.exponent() - shift);
}

double double_up(long double value) {
  const auto nearest = static_cast<double>(value);
  return nearest < value ? std::nextafter(nearest, std::numeric_limits<double>::infinity()) : nearest;
}

// Nothing when rounding errors could change the result.
std::optional<double> up_by_filter(std::span<const Point> corners, bool flat) {
  using Number = Filtered<long double>;
  const auto scaled = scaled_sides<long double>(corners, flat);
  if (!scaled) return std::nullopt;
  const auto [numerator, denominator] = squared_radius(scaled->sides, corners.size(), Number{1, 1});
  constexpr long double least = 1e-100L, error_max = 1e-4L;
  if (!(numerator.value > least && denominator.value > least)) return std::nullopt;
  // The relative errors of quotient and root are less than their sum, and 8 units leave room for four roundings.
  const long double error = numerator.error() + denominator.error() + 4 * std::numeric_limits<long double>::epsilon();
  if (!(error < error_max)) return std::nullopt;
  const long double root = std::sqrt(numerator.value / (4 * denominator.value));
  const double low = double_up(root * (1 - error)), high = double_up(root * (1 + error));
  if (low != high) return std::nullopt;
  const double result = std::ldexp(high, scaled->exponent);
  if (!std::isnormal(result)) return std::nullopt;  // it may have lost bits
  return result;
}

}  // namespace

int compare_circumradius(std::span<const Point> corners, bool flat, double radius) {
  if (const auto scaled = scaled_sides<double>(corners, flat)) {
    using Number = Filtered<double>;
    const double given = std::ldexp(radius, -scaled->exponent), length = std::min(given, radius_max);
    const auto [numerator, denominator] = squared_radius(scaled->sides, corners.size(), Number{1, 1});
    const int sign = sign_of(numerator - Number{4 * length * length, 4 * length * length} * denominator);
    // A circumradius below the largest length that is tried is also below a larger one.
    if (sign < 0 || (sign > 0 && length == given)) return sign;
  }
  return compare_exactly(corners, flat, radius);
}

double circumradius_up(std::span<const Point> corners, bool flat) {
  if (const auto found = up_by_filter(corners, flat)) return *found;
  return up_exactly(corners, flat);
}

bool in_smallest_sphere(std::span<const Point> corners, const Point& other, bool flat) {
  std::array<Point, 4> all;
  std::copy(corners.begin(), corners.end(), all.begin());
  all[corners.size()] = other;
  const auto points = std::span(all).first(corners.size() + 1);
  if (const auto scaled = scaled_sides<double>(points, flat)) {
    const int sign = sign_of(smallest_sphere(scaled->sides, corners.size()));
    if (sign != 0) return sign < 0;
  }
  const Integers given(points, flat, 0);
  return smallest_sphere(given.sides(), corners.size()) < 0;
}

}  // namespace tessera::exact
