// Finds the simplex of a Delaunay triangulation that contains a point.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "src/base/point.h"
#include "src/tiling/hilbert.h"

namespace tessera {

// The arrays of a Delaunay, which must outlive this object. REQUIRES: simplices are in the Hilbert order of their first
// vertices.
struct SimplexArrays {
  int dimension = 3;
  std::span<const double> points;  // n x dimension
  std::span<const std::int32_t> simplices, neighbors;
};

// A visibility walk: the walk leaves a simplex across any facet that has the point strictly on its other side, until
// there is no such facet. The walk ends in every Delaunay triangulation, also where points are cospherical: ties are
// broken as if the points were lifted a little, so this is a regular triangulation, in which no point sees the
// simplices in a cycle. Source: Edelsbrunner, An acyclicity theorem for cell complexes in d dimensions, Combinatorica
// 1990. Orientations are exact. So a point on a facet is in a simplex of this facet, and a point beyond the hull is
// outside.
class SimplexFinder {
 public:
  explicit SimplexFinder(const SimplexArrays& arrays);

  // out[i] becomes a simplex that contains query i, boundaries included; -1 if there is none. Several threads may call
  // find() at once.
  void find(std::span<const double> queries, std::span<std::int32_t> out) const;

 private:
  Point vertex(std::int32_t v) const { return point_of(arrays_.points, static_cast<std::size_t>(v)); }
  Point point_of(std::span<const double> coordinates, std::size_t i) const;
  // Returns where to begin: the nearer to q of `last` and a sample that is near q on the Hilbert curve.
  std::int32_t start(const Point& q, std::uint64_t key, std::int32_t last) const;
  // Returns the simplex that contains q, or -1. The walk begins in `last`, and sets it to the last simplex visited.
  template <int d>
  std::int32_t walk(const Point& q, std::int32_t& last) const;

  SimplexArrays arrays_;
  HilbertKey key_;
  std::vector<std::pair<std::uint64_t, std::int32_t>> samples_;  // (key of the first vertex, simplex), ascending
};

}  // namespace tessera
