#include "src/result/measure/exact_volume.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <type_traits>
#include <utility>

namespace tessera {

namespace {

namespace mp = boost::multiprecision;
// Holds determinants whose entries have 63 bits: 3 x 63 + 3.
using Wide = mp::number<mp::cpp_int_backend<256, 256, mp::signed_magnitude, mp::unchecked, void>, mp::et_off>;
__extension__ using Int128 = __int128;
__extension__ using Unsigned128 = unsigned __int128;

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

// The coordinates of all corners on one axis as multiples of 2^exponent, of 61 bits and a sign.
struct Multiples {
  std::array<std::int64_t, 4> at{};
  int exponent = 0;
};

// Nothing where this takes more bits, or exponents beyond those of doubles.
std::optional<Multiples> multiples_of(std::span<const Point> corners, int axis) {
  constexpr int bits = 61, exponent_max = 900;
  double most = 0;
  for (const Point& p : corners) most = std::max(most, std::abs(p[axis]));
  if (most == 0) return Multiples{};
  const int top = std::ilogb(most) + 1;
  if (std::abs(top) > exponent_max) return std::nullopt;
  Multiples made{.at = {}, .exponent = top - bits};
  const double scale = std::bit_cast<double>(static_cast<std::uint64_t>(1023 - made.exponent) << (digits - 1));
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const double scaled = corners[i][axis] * scale;
    made.at[i] = static_cast<std::int64_t>(scaled);
    if (static_cast<double>(made.at[i]) != scaled) return std::nullopt;
  }
  return made;
}

// An integer of 192 bits, as two's complement.
class Sum192 {
 public:
  void add_product(Int128 a, std::int64_t b, bool minus) {
    const bool negative = (a < 0) != (b < 0) ? !minus : minus;
    const auto size = a < 0 ? -static_cast<Unsigned128>(a) : static_cast<Unsigned128>(a);
    const auto factor = b < 0 ? -static_cast<std::uint64_t>(b) : static_cast<std::uint64_t>(b);
    const Unsigned128 low = Unsigned128{static_cast<std::uint64_t>(size)} * factor,
                      high = (size >> 64) * factor + (low >> 64);
    const std::array<std::uint64_t, 3> product{static_cast<std::uint64_t>(low), static_cast<std::uint64_t>(high),
                                               static_cast<std::uint64_t>(high >> 64)};
    Unsigned128 carry = negative ? 1 : 0;
    for (std::size_t i = 0; i < 3; ++i) {
      carry += Unsigned128{limbs_[i]} + (negative ? ~product[i] : product[i]);
      limbs_[i] = static_cast<std::uint64_t>(carry);
      carry >>= 64;
    }
  }
  Integer value() const {
    std::array<std::uint64_t, 3> size = limbs_;
    const bool negative = (limbs_[2] >> 63) != 0;
    if (negative) {
      Unsigned128 carry = 1;
      for (auto& limb : size) {
        carry += ~limb;
        limb = static_cast<std::uint64_t>(carry);
        carry >>= 64;
      }
    }
    Integer made;
    auto& backend = made.backend();
    static_assert(sizeof(mp::limb_type) == sizeof(std::uint64_t));
    backend.resize(3, 3);
    std::copy(size.begin(), size.end(), backend.limbs());
    backend.normalize();
    if (negative) backend.negate();
    return made;
  }

 private:
  std::array<std::uint64_t, 3> limbs_{};
};

// The determinant of a cell whose coordinates are not of too different sizes: nearly always. It takes a tenth of the
// time.
std::optional<ScaledInteger> quick_volume(std::span<const Point> corners) {
  const std::size_t d = corners.size() - 1;
  std::array<std::array<std::int64_t, 3>, 3> e{};
  ScaledInteger made;
  for (std::size_t axis = 0; axis < d; ++axis) {
    const auto multiples = multiples_of(corners, static_cast<int>(axis));
    if (!multiples) return std::nullopt;
    for (std::size_t i = 0; i < d; ++i) e[i][axis] = multiples->at[i + 1] - multiples->at[0];
    made.exponent += multiples->exponent;
  }
  const auto minor = [&](std::size_t i, std::size_t j, std::size_t x, std::size_t y) {
    return Int128{e[i][x]} * e[j][y] - Int128{e[i][y]} * e[j][x];
  };
  Sum192 sum;
  if (d == 2) {
    sum.add_product(minor(0, 1, 0, 1), 1, false);
  } else {
    sum.add_product(minor(1, 2, 1, 2), e[0][0], false);
    sum.add_product(minor(1, 2, 0, 2), e[0][1], true);
    sum.add_product(minor(1, 2, 0, 1), e[0][2], false);
  }
  made.value = sum.value();
  return made;
}

}  // namespace

ScaledInteger volume_times_factorial(std::span<const Point> corners) {
  if (auto quick = quick_volume(corners)) return std::move(*quick);
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
    result.value = Integer(determinant<Int128, Wide>(edges<std::int64_t>(axes, d), d));
  else
    result.value = determinant<Integer, Integer>(edges<Integer>(axes, d), d);
  return result;
}

namespace {

int width_of(Unsigned128 bits) {
  const auto high = static_cast<std::uint64_t>(bits >> 64);
  const auto low = static_cast<std::uint64_t>(bits);
  return static_cast<int>(high != 0 ? 64 + std::bit_width(high) : std::bit_width(low));
}

// The upper bits of a number: number = (bits + less than one) * 2^exponent.
struct Upper {
  Unsigned128 bits = 0;
  int exponent = 0;
  bool more = false;  // bits were dropped that are not 0
};

// `most` bits, or all, if these are fewer.
Upper upper_bits(const ScaledInteger& number, int most) {
  const auto& backend = number.value.backend();
  const mp::limb_type* const limbs = backend.limbs();
  const int top = static_cast<int>(backend.size()) - 1;
  Upper upper{.bits = limbs[top], .exponent = number.exponent + 64 * top, .more = false};
  const int bits = width_of(upper.bits), wanted = most - bits;
  if (wanted < 0) {
    upper.more = (limbs[top] & ((std::uint64_t{1} << -wanted) - 1)) != 0;
    upper.bits >>= -wanted;
    upper.exponent -= wanted;
  }
  for (int taken = 0, i = top - 1; i >= 0; --i) {
    const int part = std::clamp(wanted - taken, 0, 64);
    if (part > 0) {
      upper.bits = (upper.bits << part) | (limbs[i] >> (64 - part));
      upper.exponent -= part;
      taken += part;
    }
    upper.more = upper.more || (part < 64 && (limbs[i] << part) != 0);
  }
  return upper;
}

}  // namespace

double rounded_quotient(const ScaledInteger& number, unsigned divisor) {
  if (number.value == 0) return 0;
  const bool negative = number.value < 0;
  // So that the quotient has more bits than a double.
  constexpr int taken = 120, longer = digits + 8;
  Upper upper = upper_bits(number, taken);
  if (const int bits = width_of(upper.bits); bits < longer) {
    upper.bits <<= longer - bits;
    upper.exponent -= longer - bits;
  }
  const Unsigned128 quotient = upper.bits / divisor;
  const bool rest = upper.more || quotient * divisor != upper.bits;
  const int top = width_of(quotient) - 1;
  // The last bit that is kept: a double has 53 bits, and none below 2^-1074.
  constexpr int least = std::numeric_limits<double>::min_exponent - digits;
  const int dropped = std::max(top + 1 - digits, least - upper.exponent);
  if (dropped > top + 1) return negative ? -0.0 : 0.0;
  auto kept = static_cast<std::uint64_t>(quotient >> dropped);
  const Unsigned128 half = Unsigned128{1} << (dropped - 1);  // dropped > 0, because the quotient is longer
  const bool at_least_half = (quotient & half) != 0, more = rest || (quotient & (half - 1)) != 0;
  if (at_least_half && (more || kept % 2 == 1)) ++kept;
  const double value = std::ldexp(static_cast<double>(kept), upper.exponent + dropped);
  return negative ? -value : value;
}

ScaledDouble scaled_quotient(const ScaledInteger& number, unsigned divisor) {
  if (number.value == 0) return {};
  const Upper upper = upper_bits(number, 63);
  const auto quotient = static_cast<double>(static_cast<long double>(static_cast<std::uint64_t>(upper.bits)) / divisor);
  return ScaledDouble::of(number.value < 0 ? -quotient : quotient, upper.exponent);
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
