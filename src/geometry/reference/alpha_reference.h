// The right alpha shapes for tests: CGAL's, computed with exact numbers.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "src/base/point.h"

namespace tessera {

// Faces as sorted lists of their vertices' sorted ids.
using IdFaces = std::vector<std::vector<PointId>>;

struct ReferenceShape {
  IdFaces facets;  // of exactly one cell in the shape
  IdFaces singular_facets, singular_edges, singular_vertices;
};

// CGAL's Alpha_shape_2 or Alpha_shape_3 in the mode GENERAL. In 2D edges are facets.
class AlphaReference {
 public:
  // REQUIRES: distinct points that span the space.
  AlphaReference(std::span<const LocalPoint> points, int dimension);
  ~AlphaReference();
  ReferenceShape at(double radius) const;
  // Whether all points are in a solid component, and there is only one.
  bool is_one_piece(double radius) const;
  // The least double for which that holds.
  double least_radius() const;
  // What CGAL finds, which searches by bisection; rounded up.
  double optimal_radius() const;

 private:
  struct Impl;
  template <class Shape>
  struct ImplOf;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tessera
