// Determinants in floating point with unbounded exponents, and a bound on their error. They are for points so far
// apart, or so near to zero, that products of doubles overflow or underflow. For such points one product mostly exceeds
// all others by far and decides the sign. As integers the same points have thousands of bits.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace tessera::exact {

// The number value * 2^exponent. Its error is at most k u sum * 2^exponent, where u = 2^-53 and k is the number of
// roundings in the longest chain of operations. `sum` is the sum of the absolute values of the products that make up
// `value`; it is at least 1 unless the value is exactly 0. Products have at most 5 factors in [1, 2) and sums have few
// terms, so neither leaves the range of doubles.
struct AnyExponent {
  double value = 0, sum = 0;
  std::int32_t exponent = 0;

  AnyExponent() = default;
  explicit AnyExponent(double v) {
    if (v == 0) return;
    int e = 0;
    value = 2 * std::frexp(v, &e);
    sum = std::abs(value);
    exponent = e - 1;
  }
  friend AnyExponent operator*(const AnyExponent& a, const AnyExponent& b) {
    return {a.value * b.value, a.sum * b.sum, a.exponent + b.exponent};
  }
  friend AnyExponent operator+(const AnyExponent& a, const AnyExponent& b) { return add(a, b, 1); }
  friend AnyExponent operator-(const AnyExponent& a, const AnyExponent& b) { return add(a, b, -1); }

  // Returns +1 or -1 when the sign is certain after k roundings, else 0. `sum` itself may be a little too small. The
  // caller's k must include a reserve for that.
  int sign(int k) const {
    const double error = k * 0x1p-53 * sum;
    return (value > error) - (value < -error);
  }

 private:
  AnyExponent(double v, double s, std::int32_t e) : value(v), sum(s), exponent(e) {}

  // Returns 2^-distance, or 0 where that is less than any rounding.
  static double down(std::int32_t distance) {
    return distance > 1000 ? 0 : std::bit_cast<double>(static_cast<std::uint64_t>(1023 - distance) << 52);
  }
  static AnyExponent add(const AnyExponent& a, const AnyExponent& b, double sign) {
    if (b.sum == 0) return a;
    if (a.sum == 0) return {sign * b.value, b.sum, b.exponent};
    if (a.exponent >= b.exponent) {
      const double scale = down(a.exponent - b.exponent);
      return {a.value + sign * scale * b.value, a.sum + scale * b.sum, a.exponent};
    }
    const double scale = down(b.exponent - a.exponent);
    return {scale * a.value + sign * b.value, scale * a.sum + b.sum, b.exponent};
  }
};

// The sign of the determinant of N rows (coordinates, 1) or (lift, coordinates, 1). The rows are homogeneous, because
// differences would round. The first `columns` coordinates are columns. The lift is the sum of the squares of all L
// coordinates.
//
// Roundings: 2 in a minor, 5 in a determinant of three columns, 8 in the sum of four of these, 3 in the lift, 12 in a
// product of both, 16 in the sum of five products. The constants below leave a reserve of a quarter.
template <std::size_t N, std::size_t columns, std::size_t L>
class HomogeneousSign {
 public:
  using Rows = std::array<std::array<AnyExponent, L>, N>;
  explicit HomogeneousSign(const Rows& rows) : rows_(rows) {
    for (std::size_t j = 0; j < N; ++j) {
      for (std::size_t i = 0; i < j; ++i) pair_[i][j] = rows[i][0] * rows[j][1] - rows[i][1] * rows[j][0];
    }
  }

  // The sign of the determinant without a lift. REQUIRES: N == columns + 1.
  int orientation() const { return simplex(first(N)).sign(12); }
  // The sign of the determinant with a lift. REQUIRES: N == columns + 2.
  int lifted() const {
    AnyExponent sum;
    for (std::size_t skipped = 0; skipped < N; ++skipped) {
      AnyExponent lift;
      for (const AnyExponent& c : rows_[skipped]) lift = lift + c * c;
      const AnyExponent term = lift * simplex(first(skipped));
      sum = skipped % 2 == 0 ? sum + term : sum - term;
    }
    return sum.sign(20);
  }

 private:
  using Corners = std::array<std::size_t, columns + 1>;
  // The indices of the first columns + 1 rows other than row `skipped`.
  static Corners first(std::size_t skipped) {
    Corners corners{};
    for (std::size_t row = 0, n = 0; n <= columns; ++row) {
      if (row != skipped) corners[n++] = row;
    }
    return corners;
  }
  // The determinant of the rows (coordinates, 1), expanded along the column of ones.
  AnyExponent simplex(const Corners& c) const {
    if constexpr (columns == 2) {
      return pair_[c[1]][c[2]] - pair_[c[0]][c[2]] + pair_[c[0]][c[1]];
    } else {
      return (triple(c[0], c[1], c[2]) - triple(c[0], c[1], c[3])) +
             (triple(c[0], c[2], c[3]) - triple(c[1], c[2], c[3]));
    }
  }
  AnyExponent triple(std::size_t i, std::size_t j, std::size_t k) const {
    return rows_[i][2] * pair_[j][k] - rows_[j][2] * pair_[i][k] + rows_[k][2] * pair_[i][j];
  }

  const Rows& rows_;
  std::array<std::array<AnyExponent, N>, N> pair_;  // the minors of the first two columns; [i][j] for i < j
};

}  // namespace tessera::exact
