// Circumcentres, and what a Voronoi edge adds to the cells around it: the one sum from which the volumes of Voronoi
// cells and of parts of them are made.
//
// A cell's volume is that of the pyramids over its faces, with the vertex as apex; a face's area vector is half the sum
// of P x P' over its edges. The edge from P to P' is dual to a Delaunay facet and lies in one face for each edge of the
// facet. Gathered by vertex: of the facet (t0, t1, t2), from whose positive side P leads to P', t0 gets
// (P x P') . (t2 - t1) / 12, and so on in turn. In 2D, of the edge (t0, t1), t1 gets P x P' / 2 and t0 the opposite.
// The origin cancels out. In long doubles: circumcentres of flat cells are far away.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "src/base/point.h"

namespace tessera::query {

struct Vec {
  long double x = 0, y = 0, z = 0;
  friend Vec operator-(const Vec& a, const Vec& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend Vec operator+(const Vec& a, const Vec& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Vec operator*(long double s, const Vec& a) { return {s * a.x, s * a.y, s * a.z}; }
};

inline long double dot(const Vec& a, const Vec& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec cross(const Vec& a, const Vec& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Vec relative(const Point& p, const Point& origin) {
  return {static_cast<long double>(p.x) - origin.x, static_cast<long double>(p.y) - origin.y,
          static_cast<long double>(p.z) - origin.z};
}

// The corners of the facet opposite corner k, in such an order that with corner k behind them they are an even
// permutation: positive as the cell is.
inline constexpr std::size_t facet_3[4][3] = {{1, 3, 2}, {0, 2, 3}, {0, 3, 1}, {0, 1, 2}};
inline constexpr std::size_t facet_2[3][2] = {{1, 2}, {2, 0}, {0, 1}};
constexpr std::size_t facet_corner(std::size_t corners, std::size_t k, std::size_t i) {
  return corners == 4 ? facet_3[k][i] : facet_2[k][i];
}

// Of 3 points with z = 0, or 4. Not finite when they are flat.
Vec circumcentre(std::span<const Vec> cell);

// What each of the facet's 2 or 3 vertices gets of the Voronoi edge from `from` to `to`, which crosses the facet from
// its positive side on.
std::array<long double, 3> edge_shares(std::span<const Vec> facet, const Vec& from, const Vec& to);

}  // namespace tessera::query
