#include "src/result/measure/exact_volume.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <type_traits>

namespace tessera {

namespace {

namespace mp = boost::multiprecision;
using mp::cpp_int;
// Holds determinants whose entries have 63 bits: 3 x 63 + 3.
using Wide = mp::number<mp::cpp_int_backend<256, 256, mp::signed_magnitude, mp::unchecked, void>, mp::et_off>;
__extension__ using Int128 = __int128;

constexpr int digits = std::numeric_limits<double>::digits;

// The number odd * 2^exponent, or 0.
struct Odd {
  std::int64_t odd = 0;
  int exponent = 0;
};

Odd odd_of(double x) {
  if (x == 0) return {};
  int exponent = 0;
  const auto mantissa = static_cast<std::int64_t>(std::ldexp(std::frexp(x, &exponent), digits));
  const int zeros = std::countr_zero(static_cast<std::uint64_t>(mantissa));
  return {mantissa / (std::int64_t{1} << zeros), exponent - digits + zeros};
}

// One axis: the coordinates of all corners as multiples of the greatest possible power of two.
struct Axis {
  std::array<Odd, 4> at;
  int exponent = 0;
  int bits = 0;  // of the longest multiple
};

Axis axis_of(std::span<const Point> corners, int axis) {
  Axis result;
  bool any = false;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    result.at[i] = odd_of(corners[i][axis]);
    if (result.at[i].odd == 0) continue;
    result.exponent = any ? std::min(result.exponent, result.at[i].exponent) : result.at[i].exponent;
    any = true;
  }
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (result.at[i].odd == 0) continue;
    const auto size = static_cast<std::uint64_t>(std::abs(result.at[i].odd));
    result.bits =
        std::max(result.bits, static_cast<int>(std::bit_width(size)) + result.at[i].exponent - result.exponent);
  }
  return result;
}

template <class Integer>
Integer multiple(const Axis& axis, std::size_t corner) {
  Integer value = axis.at[corner].odd;
  if (value == 0) return value;
  const int shift = axis.at[corner].exponent - axis.exponent;
  if constexpr (std::is_same_v<Integer, std::int64_t>)
    return value * (std::int64_t{1} << shift);
  else
    return value << static_cast<unsigned>(shift);
}

// The edges from the first corner, as rows.
template <class Integer>
using Edges = std::array<std::array<Integer, 3>, 3>;

template <class Integer>
Edges<Integer> edges(const std::array<Axis, 3>& axes, std::size_t d) {
  Edges<Integer> rows;
  for (std::size_t axis = 0; axis < d; ++axis) {
    const Integer first = multiple<Integer>(axes[axis], 0);
    for (std::size_t i = 0; i < d; ++i) rows[i][axis] = multiple<Integer>(axes[axis], i + 1) - first;
  }
  return rows;
}

// `Minor` holds products of coordinates of two edges, `Whole` the determinant.
template <class Minor, class Whole, class Integer>
Whole determinant(const Edges<Integer>& e, std::size_t d) {
  const auto minor = [&](std::size_t i, std::size_t j, std::size_t x, std::size_t y) -> Minor {
    return Minor(e[i][x]) * e[j][y] - Minor(e[i][y]) * e[j][x];
  };
  if (d == 2) return Whole(minor(0, 1, 0, 1));
  return Whole(minor(1, 2, 1, 2)) * e[0][0] - Whole(minor(1, 2, 0, 2)) * e[0][1] + Whole(minor(1, 2, 0, 1)) * e[0][2];
}

}  // namespace

ScaledInteger volume_times_factorial(std::span<const Point> corners) {
  const std::size_t d = corners.size() - 1;
  std::array<Axis, 3> axes;
  ScaledInteger result;
  int bits = 0;
  for (std::size_t axis = 0; axis < d; ++axis) {
    axes[axis] = axis_of(corners, static_cast<int>(axis));
    bits = std::max(bits, axes[axis].bits);
    result.exponent += axes[axis].exponent;
  }
  // Differences have one more bit, and a sign.
  constexpr int bits_max = 62;
  if (bits <= bits_max)
    result.value = cpp_int(determinant<Int128, Wide>(edges<std::int64_t>(axes, d), d));
  else
    result.value = determinant<cpp_int, cpp_int>(edges<cpp_int>(axes, d), d);
  return result;
}

double rounded_quotient(const ScaledInteger& number, unsigned divisor) {
  if (number.value == 0) return 0;
  const bool negative = number.value < 0;
  cpp_int magnitude = mp::abs(number.value);
  // So that the quotient has more bits than a double.
  const int shift = std::max(0, digits + 8 - static_cast<int>(mp::msb(magnitude)));
  magnitude <<= static_cast<unsigned>(shift);
  cpp_int quotient, rest;
  mp::divide_qr(magnitude, cpp_int(divisor), quotient, rest);
  const int exponent = number.exponent - shift, top = static_cast<int>(mp::msb(quotient));
  // The last bit that is kept: a double has 53 bits, and none below 2^-1074.
  constexpr int least = std::numeric_limits<double>::min_exponent - digits;
  const int dropped = std::max(top + 1 - digits, least - exponent);
  if (dropped > top + 1) return negative ? -0.0 : 0.0;
  cpp_int kept = quotient >> static_cast<unsigned>(dropped);
  const auto half = static_cast<unsigned>(dropped - 1);  // dropped > 0, because the quotient is longer
  const bool at_least_half = mp::bit_test(quotient, half);
  const bool more = rest != 0 || (half > 0 && mp::lsb(quotient) < half);
  if (at_least_half && (more || mp::bit_test(kept, 0))) ++kept;
  const double value = std::ldexp(static_cast<double>(kept), exponent + dropped);
  return negative ? -value : value;
}

ScaledDouble scaled_quotient(const ScaledInteger& number, unsigned divisor) {
  if (number.value == 0) return {};
  const cpp_int magnitude = mp::abs(number.value);
  const int dropped = std::max(0, static_cast<int>(mp::msb(magnitude)) - 62);
  const auto top = static_cast<std::uint64_t>(magnitude >> static_cast<unsigned>(dropped));
  const auto quotient = static_cast<double>(static_cast<long double>(top) / divisor);
  return ScaledDouble::of(number.value < 0 ? -quotient : quotient, number.exponent + dropped);
}

void ExactSum::add(const ScaledInteger& number) {
  if (number.value == 0) return;
  if (sum_.value == 0) {
    sum_ = number;
  } else if (number.exponent >= sum_.exponent) {
    sum_.value += number.value << static_cast<unsigned>(number.exponent - sum_.exponent);
  } else {
    sum_.value <<= static_cast<unsigned>(sum_.exponent - number.exponent);
    sum_.value += number.value;
    sum_.exponent = number.exponent;
  }
}

}  // namespace tessera
