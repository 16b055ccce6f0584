// The reach of a cell of a Delaunay triangulation: where a point must be to change the cell. Properties:
//  (1) A point outside a cell's reach is not in conflict with the cell, with or without perturbation. So the cell stays
//      a cell when the point is added. The predicates are not 0 for points outside the closed sphere, nor for points
//      beyond the hull.
//  (2) Rounding never makes a reach smaller than it is.
#pragma once

#include <array>
#include <span>

#include "src/base/point.h"
#include "src/tiling/tile/circumsphere.h"

namespace tessera {

// The closed circumsphere of a finite cell.
class SphereReach {
 public:
  // `cell` has dimension + 1 vertices and is positively oriented.
  explicit SphereReach(std::span<const Point> cell);
  // Returns true if a point of the closed box may be in reach. In 2D z is ignored.
  bool meets(const Bounds& box) const;

 private:
  int dimension_;
  std::array<Point, 4> cell_{};
  Ball ball_;  // a ball that contains the sphere; where it does not decide, exact numbers do
};

// The points strictly beyond a facet of the hull. A point in the facet's plane may also change the facet, but then it
// also changes the finite cell behind the facet.
class HullReach {
 public:
  // `cell` has the vertices of the infinite cell; the entry at `infinite` is not read.
  HullReach(std::span<const Point> cell, std::size_t infinite);
  bool meets(const Bounds& box) const { return side(box) > 0; }

  // The greatest side of a corner of the box: 1 if some corner is strictly beyond the facet, 0 if none is but some
  // corner is in the plane, -1 otherwise.
  int side(const Bounds& box) const;

 private:
  int dimension_;
  std::array<Point, 4> cell_{};
  std::size_t infinite_;
};

}  // namespace tessera
