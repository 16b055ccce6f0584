// The planes of a partition as a flat binary tree, and three ways to choose them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "src/base/point.h"

namespace tessera {

// One plane. Points with coordinate < value go to child[0], the others go to child[1].
// A child >= 0 is a row of the tree; a negative child is the leaf -1-child. Row 0 is the root. An empty tree is leaf 0.
struct SplitNode {
  double value = 0;
  std::int32_t axis = 0;
  std::int32_t child[2] = {0, 0};
};

constexpr std::int32_t as_leaf(TileId tile) { return -1 - static_cast<std::int32_t>(tile.value); }
constexpr TileId tile_at(std::int32_t child) { return TileId{static_cast<std::uint32_t>(-1 - child)}; }

// Finds the leaf of a point. The child is chosen by index, not by a branch: the sides of a median split cannot be
// predicted.
inline TileId leaf_of(std::span<const SplitNode> nodes, const Point& p) {
  const double at[3] = {p.x, p.y, p.z};
  std::int32_t row = nodes.empty() ? as_leaf(TileId{0}) : 0;
  while (row >= 0) {
    const SplitNode& node = nodes[static_cast<std::size_t>(row)];
    row = node.child[at[node.axis] >= node.value];
  }
  return tile_at(row);
}

// Returns the boxes by leaf number. REQUIRES: the tree has `leaves` leaves, numbered from 0.
std::vector<Box> boxes_of(std::span<const SplitNode> nodes, std::uint32_t leaves);

// Doubles as integers in the same order (both zeros are 0): neighbouring doubles are neighbouring integers. They serve
// where any plane inside the box will do, and where floating-point arithmetic would get stuck at rounding or overflow.
std::int64_t ordinal(double x);
double from_ordinal(std::int64_t n);

// A split of `points` on `axis` with as nearly `rank` points below it as ties allow.
struct MedianSplit {
  double value = 0;
  std::size_t below = 0;  // 0 when all points have the same coordinate: then there is no split
};
MedianSplit median_split(std::span<Point> points, int axis, std::size_t rank);  // reorders points

// Returns the middle of lo and hi: lo <= midpoint <= hi, without overflow.
double midpoint(double lo, double hi);

// Makes exactly `tiles` leaves, numbered from left to right. Every split has points of the sample on both sides, unless
// all points of the node are equal; then the remaining tiles get arbitrary parts of the node's box. REQUIRES: tiles >=
// 1.
std::vector<SplitNode> build_kd_tree(int dimension, std::vector<Point> sample, std::uint32_t tiles);

// Makes boxes of equal size over `bounds`, as cubic as possible; there are from `tiles` to 1.25 * tiles boxes.
std::vector<SplitNode> build_grid(int dimension, const Bounds& bounds, std::uint32_t tiles);

// Splits the cube around `bounds` into 2^d equal cubes, and goes on while a cube has more than `limit` points of the
// sample and there are at most `leaves_max` leaves and 40 levels.
std::vector<SplitNode> build_octree(int dimension, std::vector<Point> sample, const Bounds& bounds, std::size_t limit,
                                    std::uint32_t leaves_max);
// The same, but splits the fullest leaf until there are at least `tiles` leaves.
std::vector<SplitNode> build_octree_tiles(int dimension, std::vector<Point> sample, const Bounds& bounds,
                                          std::uint32_t tiles);

}  // namespace tessera
