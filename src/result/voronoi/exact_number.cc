#include "src/result/voronoi/exact_number.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace tessera::voronoi {

namespace {

namespace mp = boost::multiprecision;

constexpr int digits = std::numeric_limits<double>::digits;
using Exact = std::array<Whole, 3>;

Exact minus(const Exact& a, const Exact& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Whole product(const Exact& a, const Exact& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Exact turn(const Exact& a, const Exact& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Point exact_circumcentre(std::span<const Point> corners) {
  int exponent = no_exponent;
  for (const Point& p : corners)
    for (int axis = 0; axis < 3; ++axis) exponent = std::min(exponent, exponent_of(p[axis]));
  if (exponent == no_exponent) exponent = 0;
  std::array<Exact, 4> at;
  for (std::size_t i = 0; i < corners.size(); ++i)
    for (int axis = 0; axis < 3; ++axis) at[i][static_cast<std::size_t>(axis)] = whole_of(corners[i][axis], exponent);
  const Exact b = minus(at[1], at[0]), c = minus(at[2], at[0]);
  const Whole bb = product(b, b), cc = product(c, c);
  Exact number;
  Whole divisor;
  if (corners.size() == 3) {
    divisor = 2 * (b[0] * c[1] - b[1] * c[0]);
    number = {bb * c[1] - cc * b[1], cc * b[0] - bb * c[0], 0};
  } else {
    const Exact d = minus(at[3], at[0]);
    const Exact cd = turn(c, d), db = turn(d, b), bc = turn(b, c);
    const Whole dd = product(d, d);
    divisor = 2 * product(b, cd);
    for (std::size_t axis = 0; axis < 3; ++axis) number[axis] = bb * cd[axis] + cc * db[axis] + dd * bc[axis];
  }
  Point centre{};
  for (std::size_t axis = 0; axis + 1 < corners.size(); ++axis)
    centre[static_cast<int>(axis)] = rounded(at[0][axis] * divisor + number[axis], divisor, exponent);
  return centre;
}

using Quick = std::array<long double, 3>;

// Each rounding of a long double is off by at most this, relative to the result. The constants below count the
// roundings of each term, and are then doubled at least.
constexpr long double unit = 0x1p-64L;

// Sets `to` to the double that is nearest to origin + offset, where the offset is off by at most `error`. False when
// the error does not tell which double is nearest; also when numbers are too large, because NaN equals nothing.
bool settle(double origin, long double offset, long double error, double& to) {
  const long double at = origin + offset, slack = error + 4 * unit * (std::abs(at) + error);
  const auto low = static_cast<double>(at - slack), high = static_cast<double>(at + slack);
  to = low == 0 ? 0.0 : low;
  return low == high && std::isfinite(low);
}

Quick quick_edge(const Point& from, const Point& to) {
  return {static_cast<long double>(to.x) - from.x, static_cast<long double>(to.y) - from.y,
          static_cast<long double>(to.z) - from.z};
}

bool quick_circumcentre_2(std::span<const Point> p, Point& centre) {
  const Quick b = quick_edge(p[0], p[1]), c = quick_edge(p[0], p[2]);
  const long double l = b[0] * c[1], r = b[1] * c[0], divisor = 2 * (l - r);
  const long double divisor_error = 16 * unit * (std::abs(l) + std::abs(r));
  const long double least = std::abs(divisor) - divisor_error;
  if (!(least > 0)) return false;
  const long double bb = b[0] * b[0] + b[1] * b[1], cc = c[0] * c[0] + c[1] * c[1];
  const auto along = [&](int axis, long double first, long double second) {
    const long double offset = (first - second) / divisor;
    const long double error =
        (32 * unit * (std::abs(first) + std::abs(second)) + std::abs(offset) * divisor_error) / least +
        4 * unit * std::abs(offset);
    return settle(p[0][axis], offset, error, centre[axis]);
  };
  return along(0, bb * c[1], cc * b[1]) && along(1, cc * b[0], bb * c[0]);
}

bool quick_circumcentre_3(std::span<const Point> p, Point& centre) {
  const std::array<Quick, 3> e{quick_edge(p[0], p[1]), quick_edge(p[0], p[2]), quick_edge(p[0], p[3])};
  std::array<Quick, 3> normal, most;  // normal[i] is the cross product of the other two edges; most bounds its terms
  std::array<long double, 3> square;
  for (std::size_t i = 0; i < 3; ++i) {
    const Quick &a = e[(i + 1) % 3], &b = e[(i + 2) % 3];
    square[i] = e[i][0] * e[i][0] + e[i][1] * e[i][1] + e[i][2] * e[i][2];
    for (std::size_t k = 0; k < 3; ++k) {
      const long double l = a[(k + 1) % 3] * b[(k + 2) % 3], r = a[(k + 2) % 3] * b[(k + 1) % 3];
      normal[i][k] = l - r;
      most[i][k] = std::abs(l) + std::abs(r);
    }
  }
  long double divisor = 0, divisor_terms = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    divisor += 2 * e[0][k] * normal[0][k];
    divisor_terms += 2 * std::abs(e[0][k]) * most[0][k];
  }
  const long double divisor_error = 32 * unit * divisor_terms, least = std::abs(divisor) - divisor_error;
  if (!(least > 0)) return false;
  for (std::size_t k = 0; k < 3; ++k) {
    long double sum = 0, terms = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      sum += square[i] * normal[i][k];
      terms += square[i] * most[i][k];
    }
    const long double offset = sum / divisor;
    const long double error =
        (48 * unit * terms + std::abs(offset) * divisor_error) / least + 4 * unit * std::abs(offset);
    const int axis = static_cast<int>(k);
    if (!settle(p[0][axis], offset, error, centre[axis])) return false;
  }
  return true;
}

}  // namespace

int exponent_of(double x) {
  if (x == 0) return no_exponent;
  int exponent = 0;
  const auto mantissa = static_cast<std::int64_t>(std::ldexp(std::frexp(x, &exponent), digits));
  return exponent - digits + std::countr_zero(static_cast<std::uint64_t>(mantissa));
}

Whole whole_of(double x, int exponent) {
  if (x == 0) return 0;
  int own = 0;
  auto mantissa = static_cast<std::int64_t>(std::ldexp(std::frexp(x, &own), digits));
  own -= digits;
  if (own >= exponent) return Whole(mantissa) << static_cast<unsigned>(own - exponent);
  return mantissa / (std::int64_t{1} << (exponent - own));
}

double rounded(const Whole& number, const Whole& divisor, int exponent) {
  if (number == 0) return 0;
  const bool negative = (number < 0) != (divisor < 0);
  Whole magnitude = mp::abs(number), by = mp::abs(divisor);
  // So that the quotient has more bits than a double.
  const int shift = std::max(0, digits + 8 - static_cast<int>(mp::msb(magnitude)) + static_cast<int>(mp::msb(by)));
  magnitude <<= static_cast<unsigned>(shift);
  Whole quotient, rest;
  mp::divide_qr(magnitude, by, quotient, rest);
  exponent -= shift;
  const int top = static_cast<int>(mp::msb(quotient));
  // The last bit that is kept: a double has 53 bits, and none below 2^-1074.
  constexpr int least = std::numeric_limits<double>::min_exponent - digits;
  const int dropped = std::max(top + 1 - digits, least - exponent);
  if (dropped > top + 1) return 0;
  Whole kept = quotient >> static_cast<unsigned>(dropped);
  const auto half = static_cast<unsigned>(dropped - 1);  // dropped > 0, because the quotient is longer
  const bool at_least_half = mp::bit_test(quotient, half);
  const bool more = rest != 0 || (half > 0 && mp::lsb(quotient) < half);
  if (at_least_half && (more || mp::bit_test(kept, 0))) ++kept;
  if (kept == 0) return 0;
  const double value = std::ldexp(static_cast<double>(kept), exponent + dropped);
  return negative ? -value : value;
}

Point circumcentre(std::span<const Point> corners) {
  Point centre{};
  const bool settled =
      corners.size() == 3 ? quick_circumcentre_2(corners, centre) : quick_circumcentre_3(corners, centre);
  return settled ? centre : exact_circumcentre(corners);
}

}  // namespace tessera::voronoi
