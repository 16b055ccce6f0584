// What CGAL says, with its own triangulation, kernel and algorithms.
#pragma once

#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "src/base/point.h"

namespace tessera::test {

class CgalAnswers {
 public:
  // `points` by source index, distinct.
  CgalAnswers(const std::vector<Point>& points, int dimension);
  ~CgalAnswers();

  // Of the convex hull of the circumcentres around the vertex; infinite when it is on the hull.
  double voronoi_volume(PointId id) const;
  // Sibson's coordinates, which add up to 1, by index; empty when CGAL has none.
  std::vector<std::pair<PointId, double>> natural(const Point& q) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// By exact constructions: whether a triangle, or tetrahedron, and a closed box have a point in common.
bool cgal_meets(std::span<const Point> cell, const Bounds& box);
// The same in the plane: a triangle and a simple polygon with its inside.
bool cgal_meets(std::span<const Point> triangle, const std::vector<Point>& ring);

}  // namespace tessera::test
