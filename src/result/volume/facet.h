// Triangles of surfaces over the plane.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "src/base/point.h"

namespace tessera::volume {

// Three vertices counterclockwise in the plane; their z are heights.
using Facet = std::array<Point, 3>;

// The same triangle, beginning with its least vertex. So what is computed of a triangle does not depend on the tile
// from which it was read.
inline Facet canonical(const Facet& facet) {
  std::size_t least = 0;
  for (std::size_t k = 1; k < 3; ++k)
    if (facet[k] < facet[least]) least = k;
  return {facet[least], facet[(least + 1) % 3], facet[(least + 2) % 3]};
}

// A closed box in the plane.
struct FlatBox {
  double left = 0, low = 0, right = 0, high = 0;
  bool meets(const FlatBox& other) const {
    return left <= other.right && other.left <= right && low <= other.high && other.low <= high;
  }
  void add(const FlatBox& other) {
    left = std::min(left, other.left);
    low = std::min(low, other.low);
    right = std::max(right, other.right);
    high = std::max(high, other.high);
  }
};

inline FlatBox box_of(const Facet& facet) {
  const auto [left, right] = std::minmax({facet[0].x, facet[1].x, facet[2].x});
  const auto [low, high] = std::minmax({facet[0].y, facet[1].y, facet[2].y});
  return {left, low, right, high};
}

}  // namespace tessera::volume
