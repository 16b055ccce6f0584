#include "src/geometry/predicates/exact/predicates.h"

#include <array>
#include <bit>
#include <boost/multiprecision/cpp_int.hpp>
#include <cstddef>
#include <optional>
#include <utility>

#include "src/geometry/predicates/exact/any_exponent.h"
#include "src/geometry/predicates/exact/bits.h"
#include "src/geometry/predicates/exact/integer.h"

namespace tessera::exact {
namespace {

using Big = boost::multiprecision::number<boost::multiprecision::cpp_int_backend<>, boost::multiprecision::et_off>;
int sign_of(const Big& v) { return v.sign(); }
int sign_of(double v) { return (v > 0) - (v < 0); }
template <std::size_t N>
int sign_of(const Integer<N>& v) {
  return v.sign();
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

// Whether all values are multiples of a power of two of which they are at most 2^bits times as large, and no product of
// degree 5 leaves the range of normal doubles.
template <std::size_t N>
bool on_lattice(const std::array<double, N>& values, int bits) {
  double greatest = 0;
  for (const double v : values) greatest = std::max(greatest, std::abs(v));
  if (!(greatest < 0x1p190)) return false;
  if (greatest < 0x1p-170) return greatest == 0;
  // The power of two above the greatest value. Adding this power times 2^(52 - bits) drops all bits below the lattice's
  // step.
  const double above = std::bit_cast<double>((std::bit_cast<std::uint64_t>(greatest) >> 52 << 52)) * 2;
  const double round = above * std::ldexp(1.5, 52 - bits);
  bool all = true;
  for (const double v : values) all &= (v + round) - round == v;
  return all;
}

// The lift of a difference: its whole squared length, or the square of one coordinate.
struct WholeLift {
  template <class T, class... More>
  auto operator()(const T& first, const More&... more) const {
    return ((first * first) + ... + (more * more));
  }
};
template <std::size_t axis>
struct LiftAlong {
  template <class T, class... More>
  auto operator()(const T& first, const More&... more) const {
    const T& c = *std::array{&first, &more...}[axis];
    return c * c;
  }
};

template <std::size_t P>
using PointSet = std::array<const Point*, P>;

// The exponents of the coordinates are arbitrary. The sign is 0 when no product exceeds the others by far enough.
template <std::size_t columns, std::size_t P, std::size_t D>
int any_exponent_sign(const PointSet<P>& points, const std::array<int, D>& axes) {
  typename HomogeneousSign<P, columns, D>::Rows rows;
  for (std::size_t i = 0; i < P; ++i)
    for (std::size_t k = 0; k < D; ++k) rows[i][k] = AnyExponent((*points[i])[axes[k]]);
  const HomogeneousSign<P, columns, D> homogeneous(rows);
  if constexpr (P == columns + 2) {
    return homogeneous.lifted();
  } else {
    return homogeneous.orientation();
  }
}

template <std::size_t N>
Big big_of(const Integer<N>& v) {
  const Integer<N> magnitude = v.negative() ? Integer<N>{} - v : v;
  Big to = 0;
  boost::multiprecision::import_bits(to, magnitude.limb.begin(), magnitude.limb.end(), 64, false);
  return v.negative() ? -to : to;
}

// Scales each axis by a power of two of its own. A determinant that is linear in its columns keeps its sign then. A
// determinant with a lift is a sum over axes: each part has the squares along one axis, times the square of that axis's
// power. Returns nothing when an axis spans too many bits.
template <std::size_t columns, std::size_t P, std::size_t D, class Sign>
std::optional<int> per_axis_sign(const std::array<double, P * D>& coordinate, Sign&& sign) {
  std::array<int, D> low{};
  std::array<Integer<2>, (P - 1) * D> exact;
  for (std::size_t k = 0; k < D; ++k) {
    std::array<double, P> along;
    for (std::size_t i = 0; i < P; ++i) along[i] = coordinate[i * D + k];
    const BitRange range(along);
    if (range.bits() > 125) return std::nullopt;
    low[k] = range.low;
    std::array<Integer<2>, P> scaled;
    for (std::size_t i = 0; i < P; ++i) scale(along[i], range.low, scaled[i]);
    for (std::size_t i = 0; i + 1 < P; ++i) exact[i * D + k] = scaled[i] - scaled[P - 1];
  }
  if constexpr (P == columns + 1) {
    return sign_of(sign(exact, WholeLift{}));
  } else {
    const int least = *std::min_element(low.begin(), low.end());
    Big sum = 0;
    int all = 0, signs = 0;  // the signs of the parts as bits: 1 positive, 2 negative
    const auto add = [&]<std::size_t k>() {
      const auto part = sign(exact, LiftAlong<k>{});
      if (part.sign() == 0) return;
      all = part.sign();
      signs |= part.sign() > 0 ? 1 : 2;
      sum += big_of(part) << static_cast<unsigned>(2 * (low[k] - least));
    };
    [&]<std::size_t... k>(std::index_sequence<k...>) { (add.template operator()<k>(), ...); }
    (std::make_index_sequence<D>());
    return signs == 3 ? sign_of(sum) : all;
  }
}

// Calls sign(differences, lift) with the exact differences of the points to the last point, times a common power of
// two, or times a power for each axis. There are P points of D coordinates. The first `columns` coordinates are columns
// of the determinant, and all D are in the lift, if it has one. The highest degree is 5, with 72 terms. With
// differences below 2^62 (1 limb) or 2^126 (2 limbs), 5 times as many limbs hold every determinant. Doubles hold it as
// an integer below 2^53 when differences are at most 2^lattice_bits.
template <std::size_t columns, int lattice_bits, std::size_t P, std::size_t D, class Sign>
Staged with_differences(const PointSet<P>& points, const std::array<int, D>& axes, Sign&& sign) {
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
    if (on_lattice(difference, lattice_bits)) return {sign_of(sign(difference, WholeLift{})), PredicateStage::lattice};
    if (const BitRange range(difference); range.bits() <= 62) {
      std::array<Integer<1>, n> scaled;
      for (std::size_t i = 0; i < n; ++i) scale(difference[i], range.low, scaled[i]);
      return {sign_of(sign(scaled, WholeLift{})), PredicateStage::integer};
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
    return sign_of(sign(exact, WholeLift{}));
  };
  if (range.bits() <= 125) return {with(Integer<2>{}), PredicateStage::wide};
  if (const int certain = any_exponent_sign<columns>(points, axes); certain != 0)
    return {certain, PredicateStage::any_exponent};
  if (const auto found = per_axis_sign<columns, P, D>(coordinate, sign)) return {*found, PredicateStage::axes};
  return {with(Big{}), PredicateStage::big};
}

template <class T>
auto minor(const T& ax, const T& ay, const T& bx, const T& by) {
  return ax * by - ay * bx;
}
// The determinant of three rows (x, y, l).
template <class T, class L>
auto determinant(const T& ax, const T& ay, const L& al, const T& bx, const T& by, const L& bl, const T& cx, const T& cy,
                 const L& cl) {
  return al * minor(bx, by, cx, cy) + bl * minor(cx, cy, ax, ay) + cl * minor(ax, ay, bx, by);
}

// Whether all points have the same x, the same y, or the same z.
template <std::size_t P>
bool axis_parallel(const std::array<const Point*, P>& points) {
  const auto equal = [&](auto coordinate) {
    return std::all_of(points.begin(), points.end(),
                       [&](const Point* p) { return p->*coordinate == points[0]->*coordinate; });
  };
  return equal(&Point::x) || equal(&Point::y) || equal(&Point::z);
}

// Bits of differences such that a determinant stays below 2^53. Its terms: 2 of degree 2, 6 of degree 3, 12 (18 in a
// plane in space) of degree 4, 72 of degree 5.
constexpr int area_bits = 25, volume_bits = 16, circle_bits = 12, sphere_bits = 9;
constexpr std::array<int, 2> xy{0, 1};
constexpr std::array<int, 3> xyz{0, 1, 2};

Staged projected_orientation(const Point& a, const Point& b, const Point& c, const std::array<int, 2>& axes) {
  return with_differences<2, area_bits>(PointSet<3>{&a, &b, &c}, axes,
                                        [](const auto& v, const auto&) { return minor(v[0], v[1], v[2], v[3]); });
}

}  // namespace

Staged orientation_2_exact(const Point& a, const Point& b, const Point& c) {
  return projected_orientation(a, b, c, xy);
}

Staged orientation_3_exact(const Point& a, const Point& b, const Point& c, const Point& d) {
  if (axis_parallel<4>({&a, &b, &c, &d})) return {0, PredicateStage::lattice};
  // The rows are b, a, c, because differences to the last point instead of the first reverse the sign.
  return with_differences<3, volume_bits>(PointSet<4>{&b, &a, &c, &d}, xyz, [](const auto& v, const auto&) {
    return determinant(v[0], v[1], v[2], v[3], v[4], v[5], v[6], v[7], v[8]);
  });
}

Staged in_circle_2_exact(const Point& a, const Point& b, const Point& c, const Point& d) {
  return with_differences<2, circle_bits>(PointSet<4>{&a, &b, &c, &d}, xy, [](const auto& v, const auto& lift) {
    return determinant(v[0], v[1], lift(v[0], v[1]), v[2], v[3], lift(v[2], v[3]), v[4], v[5], lift(v[4], v[5]));
  });
}

Staged in_sphere_3_exact(const Point& a, const Point& b, const Point& c, const Point& d, const Point& e) {
  if (axis_parallel<5>({&a, &b, &c, &d, &e})) return {0, PredicateStage::lattice};
  return with_differences<3, sphere_bits>(PointSet<5>{&a, &b, &c, &d, &e}, xyz, [](const auto& v, const auto& lift) {
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

// In the plane, any two coordinates that are independent there serve as well as orthogonal ones. The lift is the true
// squared distance in space.
int coplanar_in_circle(const Point& a, const Point& b, const Point& c, const Point& d) {
  // `axes` holds the two independent axes, then the third.
  const auto lifted = [&](const std::array<int, 3>& axes) {
    return with_differences<2, circle_bits>(PointSet<4>{&a, &b, &c, &d}, axes,
                                            [](const auto& v, const auto& lift) {
                                              return determinant(v[0], v[1], lift(v[0], v[1], v[2]), v[3], v[4],
                                                                 lift(v[3], v[4], v[5]), v[6], v[7],
                                                                 lift(v[6], v[7], v[8]));
                                            })
        .sign;
  };
  if (const int turn = orientation_2(a, b, c); turn != 0) return turn * lifted({0, 1, 2});
  if (const int turn = projected_orientation(a, b, c, {1, 2}).sign; turn != 0) return turn * lifted({1, 2, 0});
  return projected_orientation(a, b, c, {0, 2}).sign * lifted({0, 2, 1});
}

namespace {

// The perturbation lifts the lexicographically greatest point by the largest infinitesimal, the next point by a smaller
// one, and so on. So the greatest point whose lift matters decides. If this point is the query, the query rises out of
// the circle or sphere. If it is a vertex, the circle or sphere bends towards or away from the query; the orientation
// with the query in the vertex's place says which.
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
