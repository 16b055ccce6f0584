// Circumcentres, and what a Voronoi edge contributes to the cells around it. The volumes of Voronoi cells and of their
// parts are sums of these contributions.
//
// The volume of a Voronoi cell is that of the pyramids over its faces with the vertex as apex. A face's area vector is
// half the sum of P x P' over its edges. The edge from P to P' is dual to a Delaunay facet, and belongs to one face for
// each edge of this facet. Collected by vertex: for the facet (t0, t1, t2), from whose positive side P the edge leads
// to P', t0 gets (P x P') . (t2 - t1) / 12, and t1 and t2 likewise in turn. In 2D, for the edge (t0, t1), t1 gets P x
// P' / 2 and t0 the opposite. The origin cancels out.
#pragma once

#include <array>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cstddef>
#include <optional>
#include <span>

#include "src/base/point.h"

namespace tessera::query {

// In flat cells nothing may be left of products of three differences. Long is fast. Quad has 113 bits, and takes ten
// times as long. Wide is exact for products of four differences of coordinates with some 120 bits, and takes a hundred
// times as long.
using Long = long double;
using Quad = boost::multiprecision::number<boost::multiprecision::cpp_bin_float_quad::backend_type,
                                           boost::multiprecision::et_off>;
using Wide =
    boost::multiprecision::number<boost::multiprecision::cpp_bin_float<512, boost::multiprecision::digit_base_2>,
                                  boost::multiprecision::et_off>;

template <class Number>
struct Vec {
  Number x = 0, y = 0, z = 0;
  friend Vec operator-(const Vec& a, const Vec& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend Vec operator+(const Vec& a, const Vec& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Vec operator*(Number s, const Vec& a) { return {s * a.x, s * a.y, s * a.z}; }
};

template <class Number>
Number dot(const Vec<Number>& a, const Vec<Number>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class Number>
Vec<Number> cross(const Vec<Number>& a, const Vec<Number>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class Number>
Vec<Number> relative(const Point& p, const Point& origin) {
  return {Number(p.x) - Number(origin.x), Number(p.y) - Number(origin.y), Number(p.z) - Number(origin.z)};
}
template <class Number>
bool usable(const Number& divisor) {
  return divisor != 0 && divisor - divisor == 0;  // NOLINT(misc-redundant-expression): not for infinities and NaN
}
inline long double rounded(Long number) { return number; }
inline long double rounded(const Quad& number) { return number.convert_to<long double>(); }
inline long double rounded(const Wide& number) { return number.convert_to<long double>(); }

// The corners of the facet opposite corner k, in such an order that with corner k after them they are an even
// permutation of the cell's corners: so they have the cell's orientation.
inline constexpr std::size_t facet_3[4][3] = {{1, 3, 2}, {0, 2, 3}, {0, 3, 1}, {0, 1, 2}};
inline constexpr std::size_t facet_2[3][2] = {{1, 2}, {2, 0}, {0, 1}};
constexpr std::size_t facet_corner(std::size_t corners, std::size_t k, std::size_t i) {
  return corners == 4 ? facet_3[k][i] : facet_2[k][i];
}

// The circumcentre of 3 points with z = 0, or of 4 points; nothing when they are flat.
template <class Number>
std::optional<Vec<Number>> circumcentre(std::span<const Vec<Number>> cell) {
  const Vec<Number> b = cell[1] - cell[0], c = cell[2] - cell[0];
  if (cell.size() == 3) {
    const Number area = 2 * (b.x * c.y - b.y * c.x), bb = dot(b, b), cc = dot(c, c);
    if (!usable(area)) return std::nullopt;
    return cell[0] + Vec<Number>{(bb * c.y - cc * b.y) / area, (cc * b.x - bb * c.x) / area, 0};
  }
  const Vec<Number> d = cell[3] - cell[0];
  const Number volume = 2 * dot(b, cross(c, d));
  if (!usable(volume)) return std::nullopt;
  return cell[0] + (1 / volume) * (dot(b, b) * cross(c, d) + dot(c, c) * cross(d, b) + dot(d, d) * cross(b, c));
}

// The contributions to the facet's 2 or 3 vertices of the Voronoi edge from `from` to `to`. The edge crosses the facet
// from its positive side.
template <class Number>
std::array<Number, 3> edge_shares(std::span<const Vec<Number>> facet, const Vec<Number>& from, const Vec<Number>& to) {
  const Vec<Number> turn = cross(from, to);
  if (facet.size() == 2) return {-turn.z / 2, turn.z / 2, 0};
  return {dot(turn, facet[2] - facet[1]) / 12, dot(turn, facet[0] - facet[2]) / 12,
          dot(turn, facet[1] - facet[0]) / 12};
}

}  // namespace tessera::query
