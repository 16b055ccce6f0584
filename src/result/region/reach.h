// Where a point must be to change a cell of a Delaunay triangulation, perturbed or not. Properties:
//  (1) A point outside of a cell's reach is in no conflict with it, whatever the ties: the cell is one of the
//      triangulation with it, too. For all that is not in the closed sphere, or beyond the hull, the predicates are not
//      0.
//  (2) Rounding never makes a reach smaller than it is.
#pragma once

#include <array>
#include <span>

#include "src/base/point.h"
#include "src/tiling/tile/circumsphere.h"

namespace tessera {

// The closed circumsphere of a cell. A point outside is in no conflict with the cell, whatever the ties: the cell is
// one of the triangulation with it, too.
class SphereReach {
 public:
  // `cell`: dimension + 1 vertices, positively oriented.
  explicit SphereReach(std::span<const Point> cell);
  // Whether a point of the closed box may be in reach. In 2D z does not count.
  bool meets(const Bounds& box) const;

 private:
  int dimension_;
  std::array<Point, 4> cell_{};
  Ball ball_;  // the sphere is inside; where that cannot be told, numbers of any length decide
};

// What is strictly beyond a facet of the hull. What is in its plane may change the facet, but then also the cell
// behind.
class HullReach {
 public:
  // `cell`: the vertices of the infinite cell; that at `infinite` is not looked at.
  HullReach(std::span<const Point> cell, std::size_t infinite);
  bool meets(const Bounds& box) const { return side(box) > 0; }

  // The greatest sign of the side of the box's corners: 1, some are strictly beyond; 0, some are in the plane; -1.
  int side(const Bounds& box) const;

 private:
  int dimension_;
  std::array<Point, 4> cell_{};
  std::size_t infinite_;
};

}  // namespace tessera
