#include "src/predicates/exact/predicates.h"

#include <array>
#include <bit>
#include <boost/multiprecision/cpp_int.hpp>
#include <cstddef>
#include <span>

#include "src/predicates/exact/integer.h"

namespace tessera::exact {
namespace {

using Big = boost::multiprecision::number<boost::multiprecision::cpp_int_backend<>, boost::multiprecision::et_off>;
int sign_of(const Big& v) { return v.sign(); }
int sign_of(double v) { return (v > 0) - (v < 0); }
template <std::size_t N>
int sign_of(const Integer<N>& v) {
  return v.sign();
}

// A finite double as magnitude * 2^exponent; all of them but 0 are odd.
struct Parts {
  std::uint64_t magnitude = 0;
  int exponent = 0;
  bool negative = false;
  explicit Parts(double v) {
    const auto bits = std::bit_cast<std::uint64_t>(v);
    const int field = static_cast<int>(bits >> 52 & 0x7ff);
    negative = bits >> 63;
    magnitude = (bits & ((std::uint64_t{1} << 52) - 1)) | (std::uint64_t{field != 0} << 52);
    if (magnitude == 0) return;
    const int zeros = std::countr_zero(magnitude);
    magnitude >>= zeros;
    exponent = std::max(field, 1) - 1075 + zeros;
  }
  int end() const { return exponent + std::bit_width(magnitude); }  // |v| < 2^end
};

// The bits that a set of doubles spans: all are multiples of 2^low and less than 2^high in absolute value.
struct BitRange {
  int low = 5000, high = -5000;
  template <std::size_t N>
  explicit BitRange(const std::array<double, N>& values) {
    for (const double v : values) {
      const Parts p(v);
      if (p.magnitude == 0) continue;
      low = std::min(low, p.exponent);
      high = std::max(high, p.end());
    }
  }
  int bits() const { return high - low; }  // negative when all are 0
};

void scale(double v, int low, Integer<1>& to) {
  const Parts p(v);
  if (p.magnitude == 0) return;
  const std::uint64_t m = p.magnitude << (p.exponent - low);
  to.limb[0] = p.negative ? 0 - m : m;
}

void scale(double v, int low, Integer<2>& to) {
  const Parts p(v);
  if (p.magnitude == 0) return;
  Wide m = Wide{p.magnitude} << (p.exponent - low);
  if (p.negative) m = 0 - m;
  to.limb = {static_cast<std::uint64_t>(m), static_cast<std::uint64_t>(m >> 64)};
}

void scale(double v, int low, Big& to) {
  const Parts p(v);
  if (p.magnitude == 0) return;
  to = p.magnitude;
  to <<= static_cast<unsigned>(p.exponent - low);
  if (p.negative) to = -to;
}

// The exact error of the double `difference` = a - b (Knuth's two-sum). NaN on overflow.
double tail(double a, double b, double difference) {
  const double b_virtual = a - difference;
  const double a_virtual = difference + b_virtual;
  return (a - a_virtual) + (b_virtual - b);
}

// Whether the values are multiples of a power of two, at most 2^bits times as large, and none of their products of
// degree 5 leaves the range of normal doubles.
template <std::size_t N>
bool on_lattice(const std::array<double, N>& values, int bits) {
  double greatest = 0;
  for (const double v : values) greatest = std::max(greatest, std::abs(v));
  if (!(greatest < 0x1p190)) return false;
  if (greatest < 0x1p-170) return greatest == 0;
  // The power of two above the greatest value; adding it times 2^(52 - bits) leaves no bit below the lattice's step.
  const double above = std::bit_cast<double>((std::bit_cast<std::uint64_t>(greatest) >> 52 << 52)) * 2;
  const double round = above * std::ldexp(1.5, 52 - bits);
  bool all = true;
  for (const double v : values) all &= (v + round) - round == v;
  return all;
}

// Calls sign(differences) with the differences of the points to the last one, exact, times a common power of two: `P`
// points of `D` coordinates. The highest degree is 5, of 72 terms: with differences below 2^62 (limbs of 64 bits) or
// 2^126 (of 128) 5 times as many limbs hold every determinant. Doubles hold it, as an integer below 2^53, when
// differences are at most 2^`lattice_bits`.
template <std::size_t P, std::size_t D, int lattice_bits, class Sign>
Staged with_differences(const std::array<const Point*, P>& points, const std::array<int, D>& axes, Sign&& sign) {
  constexpr std::size_t n = (P - 1) * D;
  const Point& last = *points[P - 1];
  std::array<double, n> difference;
  bool all_exact = true;
  for (std::size_t i = 0; i < n; ++i) {
    const double a = (*points[i / D])[axes[i % D]], b = last[axes[i % D]];
    difference[i] = a - b;
    all_exact &= tail(a, b, difference[i]) == 0;
  }
  if (all_exact) {
    if (on_lattice(difference, lattice_bits)) return {sign_of(sign(difference)), Stage::lattice};
    if (const BitRange range(difference); range.bits() <= 62) {
      std::array<Integer<1>, n> scaled;
      for (std::size_t i = 0; i < n; ++i) scale(difference[i], range.low, scaled[i]);
      return {sign_of(sign(scaled)), Stage::integer};
    }
  }
  std::array<double, P * D> coordinate;
  for (std::size_t i = 0; i < P * D; ++i) coordinate[i] = (*points[i / D])[axes[i % D]];
  const BitRange range(coordinate);
  const auto with = [&]<class T>(T) {
    std::array<T, P * D> scaled;
    for (std::size_t i = 0; i < P * D; ++i) scale(coordinate[i], range.low, scaled[i]);
    std::array<T, n> exact;
    for (std::size_t i = 0; i < n; ++i) exact[i] = scaled[i] - scaled[n + i % D];
    return sign_of(sign(exact));
  };
  if (range.bits() <= 125) return {with(Integer<2>{}), Stage::wide};
  return {with(Big{}), Stage::big};
}

template <class T>
auto minor(const T& ax, const T& ay, const T& bx, const T& by) {
  return ax * by - ay * bx;
}
template <class T>
auto lift(const T& x, const T& y) {
  return x * x + y * y;
}
template <class T>
auto lift(const T& x, const T& y, const T& z) {
  return x * x + y * y + z * z;
}
// The determinant of three rows (x, y, l).
template <class T, class L>
auto determinant(const T& ax, const T& ay, const L& al, const T& bx, const T& by, const L& bl, const T& cx, const T& cy,
                 const L& cl) {
  return al * minor(bx, by, cx, cy) + bl * minor(cx, cy, ax, ay) + cl * minor(ax, ay, bx, by);
}

// Whether all points have the same x, or y, or z.
template <std::size_t P>
bool axis_parallel(const std::array<const Point*, P>& points) {
  const auto equal = [&](auto coordinate) {
    return std::all_of(points.begin(), points.end(),
                       [&](const Point* p) { return p->*coordinate == points[0]->*coordinate; });
  };
  return equal(&Point::x) || equal(&Point::y) || equal(&Point::z);
}

// Bits of differences so that the determinant stays below 2^53: 2 terms of degree 2, 6 of degree 3, 12 (in a plane in
// space: 18) of degree 4, 72 of degree 5.
constexpr int area_bits = 25, volume_bits = 16, circle_bits = 12, sphere_bits = 9;
constexpr std::array<int, 2> xy{0, 1};
constexpr std::array<int, 3> xyz{0, 1, 2};

Staged projected_orientation(const Point& a, const Point& b, const Point& c, const std::array<int, 2>& axes) {
  return with_differences<3, 2, area_bits>({&a, &b, &c}, axes,
                                           [](const auto& v) { return minor(v[0], v[1], v[2], v[3]); });
}

}  // namespace

Staged orientation_2_exact(const Point& a, const Point& b, const Point& c) {
  return projected_orientation(a, b, c, xy);
}

Staged orientation_3_exact(const Point& a, const Point& b, const Point& c, const Point& d) {
  if (axis_parallel<4>({&a, &b, &c, &d})) return {0, Stage::lattice};
  // Rows b, a, c: differences to the last point instead of the first turn the sign.
  return with_differences<4, 3, volume_bits>({&b, &a, &c, &d}, xyz, [](const auto& v) {
    return determinant(v[0], v[1], v[2], v[3], v[4], v[5], v[6], v[7], v[8]);
  });
}

Staged in_circle_2_exact(const Point& a, const Point& b, const Point& c, const Point& d) {
  return with_differences<4, 2, circle_bits>({&a, &b, &c, &d}, xy, [](const auto& v) {
    return determinant(v[0], v[1], lift(v[0], v[1]), v[2], v[3], lift(v[2], v[3]), v[4], v[5], lift(v[4], v[5]));
  });
}

Staged in_sphere_3_exact(const Point& a, const Point& b, const Point& c, const Point& d, const Point& e) {
  if (axis_parallel<5>({&a, &b, &c, &d, &e})) return {0, Stage::lattice};
  return with_differences<5, 3, sphere_bits>({&a, &b, &c, &d, &e}, xyz, [](const auto& v) {
    const auto ab = minor(v[0], v[1], v[3], v[4]), bc = minor(v[3], v[4], v[6], v[7]);
    const auto cd = minor(v[6], v[7], v[9], v[10]), da = minor(v[9], v[10], v[0], v[1]);
    const auto ac = minor(v[0], v[1], v[6], v[7]), bd = minor(v[3], v[4], v[9], v[10]);
    const auto &az = v[2], &bz = v[5], &cz = v[8], &dz = v[11];
    const auto abc = az * bc - bz * ac + cz * ab, bcd = bz * cd - cz * bd + dz * bc;
    const auto cda = cz * da + dz * ac + az * cd, dab = dz * ab + az * bd + bz * da;
    return (lift(v[0], v[1], az) * bcd - lift(v[3], v[4], bz) * cda) +
           (lift(v[6], v[7], cz) * dab - lift(v[9], v[10], dz) * abc);
  });
}

int coplanar_orientation(const Point& a, const Point& b, const Point& c) {
  if (const int sign = orientation_2(a, b, c); sign != 0) return sign;
  for (const auto& axes : {std::array{1, 2}, std::array{0, 2}}) {
    if (const int sign = projected_orientation(a, b, c, axes).sign; sign != 0) return sign;
  }
  return 0;
}

// In the plane, any two coordinates that are independent there serve as well as orthogonal ones; the lift is the true
// squared distance in space.
int coplanar_in_circle(const Point& a, const Point& b, const Point& c, const Point& d) {
  const auto lifted = [&]<std::size_t U, std::size_t W>() {
    return with_differences<4, 3, circle_bits>({&a, &b, &c, &d}, xyz, [](const auto& v) {
      return determinant(v[U], v[W], lift(v[0], v[1], v[2]), v[3 + U], v[3 + W], lift(v[3], v[4], v[5]), v[6 + U],
                         v[6 + W], lift(v[6], v[7], v[8]));
    });
  };
  if (const int turn = orientation_2(a, b, c); turn != 0) return turn * lifted.operator()<0, 1>().sign;
  if (const int turn = projected_orientation(a, b, c, {1, 2}).sign; turn != 0)
    return turn * lifted.operator()<1, 2>().sign;
  return projected_orientation(a, b, c, {0, 2}).sign * lifted.operator()<0, 2>().sign;
}

namespace {

// The lexicographically greatest point is lifted by the largest infinitesimal, the next by a smaller one, and so on. So
// the greatest point whose lift matters decides: if it is the query, the query rises out of the circle or sphere; if it
// is a vertex, that bends towards or away from the query as the orientation with the query in its place tells.
template <std::size_t N, class Greater, class Orient>
int decide_tie(const std::array<const Point*, N>& points, Greater&& greater, Orient&& orient) {
  std::array<const Point*, N> order = points;
  std::sort(order.begin(), order.end(), [&](const Point* p, const Point* q) { return greater(*p, *q); });
  const Point* const query = points[N - 1];
  for (const Point* const greatest : order) {
    if (greatest == query) return -1;
    std::array<const Point*, N> with = points;
    std::replace(with.begin(), with.end(), greatest, query);
    if (const int sign = orient(with); sign != 0) return sign;
  }
  return 0;
}

}  // namespace

int in_circle_tie_2(const Point& a, const Point& b, const Point& c, const Point& d) {
  const auto greater = [](const Point& p, const Point& q) { return p.x != q.x ? p.x > q.x : p.y > q.y; };
  const auto orient = [](const auto& p) { return orientation_2(*p[0], *p[1], *p[2]); };
  return decide_tie<4>({&a, &b, &c, &d}, greater, orient);
}

int in_sphere_tie_3(const Point& a, const Point& b, const Point& c, const Point& d, const Point& e) {
  const auto greater = [](const Point& p, const Point& q) { return p > q; };
  const auto orient = [](const auto& p) { return orientation_3(*p[0], *p[1], *p[2], *p[3]); };
  return decide_tie<5>({&a, &b, &c, &d, &e}, greater, orient);
}

int coplanar_in_circle_perturbed(const Point& a, const Point& b, const Point& c, const Point& d) {
  if (const int side = coplanar_in_circle(a, b, c, d); side != 0) return side;
  const int turn = coplanar_orientation(a, b, c);
  const auto greater = [](const Point& p, const Point& q) { return p > q; };
  const auto orient = [turn](const auto& p) { return turn * coplanar_orientation(*p[0], *p[1], *p[2]); };
  return decide_tie<4>({&a, &b, &c, &d}, greater, orient);
}

}  // namespace tessera::exact
