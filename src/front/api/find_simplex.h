// Which simplex of a Delaunay triangulation holds a point.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "src/base/point.h"
#include "src/tiling/hilbert.h"

namespace tessera {

// The arrays are those of class Delaunay, and must outlive this. REQUIRES: cells come in the Hilbert order of their
// first vertices.
struct SimplexArrays {
  int dimension = 3;
  std::span<const double> points;  // n x dimension
  std::span<const std::int32_t> simplices, neighbors;
};

// A visibility walk: from a simplex across any facet that has the point strictly on its other side, until there is
// none. Ends in every Delaunay triangulation, and also where points are cospherical: ties are broken as if the points
// were lifted a little, so this is a regular triangulation, in which no point sees the simplices in a cycle.
// Source: Edelsbrunner, An acyclicity theorem for cell complexes in d dimensions, Combinatorica 1990.
// Orientations are exact, so a point on a facet is in one of its simplices, and one beyond a facet of the hull outside.
class SimplexFinder {
 public:
  explicit SimplexFinder(const SimplexArrays& arrays);

  // out[i]: a simplex that holds queries[i], boundaries included, or -1. Const, and safe in several threads.
  void find(std::span<const double> queries, std::span<std::int32_t> out) const;

 private:
  Point vertex(std::int32_t v) const { return point_of(arrays_.points, static_cast<std::size_t>(v)); }
  Point point_of(std::span<const double> coordinates, std::size_t i) const;
  // Where to begin: the nearer one of `last` and of what the curve has near q.
  std::int32_t start(const Point& q, std::uint64_t key, std::int32_t last) const;
  // The simplex that holds q, or -1; `last` becomes the last one visited.
  template <int d>
  std::int32_t walk(const Point& q, std::int32_t& last) const;

  SimplexArrays arrays_;
  HilbertKey key_;
  std::vector<std::pair<std::uint64_t, std::int32_t>> samples_;  // (key of its first vertex, simplex), ascending
};

}  // namespace tessera
