// The polygons to which Voronoi cells are clipped, as edges with an index.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "src/base/point.h"

namespace tessera::voronoi {

// The region is the union of polygons. A polygon is a set of rings with their insides, by the even-odd rule: holes are
// rings, too.
class ClipRegion {
 public:
  struct Edge {
    Point a, b;  // different; z = 0
    std::uint32_t polygon = 0;
  };
  static constexpr std::uint64_t bytes_of_edge = 128;

  // Adds a polygon's rings, in any direction; the first vertex of a ring is not repeated. Call index() afterwards.
  void add(std::span<const std::vector<Point>> rings);
  void index();

  const std::vector<Edge>& edges() const { return edges_; }
  const Bounds& bounds() const { return bounds_; }
  int exponent() const { return exponent_; }   // all coordinates are multiples of 2 to the power of it
  bool one_part() const { return one_part_; }  // whether each cell's part is surely one piece: the region is convex
  void set_convex() { one_part_ = true; }

  // Whether a point that is on no edge is in the region. Exact.
  bool contains(const Point& p) const;
  // Whether a point is in the region or on one of its edges. Exact. REQUIRES: z = 0.
  bool covers(const Point& p) const;
  // The edges that cross the edge, or touch it elsewhere than at a common end.
  std::span<const std::uint32_t> crossing(std::uint32_t edge) const;

  // Calls take(edge number) for the edges in boxes for which wanted(box) holds. `wanted` holds for a box if it holds
  // for a smaller one.
  template <class Wanted, class Take>
  void visit(const Wanted& wanted, const Take& take) const {
    if (!edges_.empty()) visit(1, wanted, take);
  }

 private:
  static constexpr std::size_t edges_of_leaf = 4;

  template <class Wanted, class Take>
  void visit(std::size_t node, const Wanted& wanted, const Take& take) const {
    const Bounds& box = boxes_[node];
    if (!(box.lo.x <= box.hi.x) || !wanted(box)) return;
    if (node < leaves_) {
      visit(2 * node, wanted, take);
      visit(2 * node + 1, wanted, take);
      return;
    }
    const std::size_t first = (node - leaves_) * edges_of_leaf;
    for (std::size_t i = first; i < std::min(first + edges_of_leaf, edges_.size()); ++i)
      if (wanted(box_of(edges_[i]))) take(static_cast<std::uint32_t>(i));
  }
  static Bounds box_of(const Edge& edge);
  void find_crossings();

  std::vector<Edge> edges_;
  std::uint32_t polygons_ = 0;
  Bounds bounds_;
  int exponent_ = 0;
  bool one_part_ = false;
  // A complete binary tree over leaves of successive edges: the children of node i are 2 i and 2 i + 1.
  std::size_t leaves_ = 0;
  std::vector<Bounds> boxes_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs_;
  std::vector<std::uint32_t> crossed_;
};

// Whether an odd number of one polygon is in the list, which is sorted by this function.
bool has_odd(std::vector<std::uint32_t>& polygons);

}  // namespace tessera::voronoi
