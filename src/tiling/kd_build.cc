// A kd-tree: median splits along the longest side of the points' bounds.
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "src/tiling/split_tree.h"

namespace tessera {
namespace {

// Returns the number of doubles in [lo, hi).
std::uint64_t width(double lo, double hi) {
  return static_cast<std::uint64_t>(ordinal(hi)) - static_cast<std::uint64_t>(ordinal(lo));
}

class KdBuilder {
 public:
  KdBuilder(int dimension, std::vector<Point> sample) : dimension_(dimension), sample_(std::move(sample)) {}

  std::vector<SplitNode> build(std::uint32_t tiles) {
    grow(sample_, Box{}, tiles);
    return std::move(nodes_);
  }

 private:
  struct Choice {
    int axis = -1;
    MedianSplit split;
  };

  // Returns the child that the parent stores.
  std::int32_t grow(std::span<Point> points, const Box& box, std::uint32_t tiles) {
    if (tiles == 1) return as_leaf(TileId{leaves_++});
    Choice choice = split_points(points, tiles);
    if (choice.axis < 0) choice = split_box(box);
    Box below = box;
    Box above = box;
    below.hi[choice.axis] = choice.split.value;
    above.lo[choice.axis] = choice.split.value;
    const std::uint32_t tiles_below = share(points.size(), choice.split.below, below, above, tiles);

    const auto row = static_cast<std::int32_t>(nodes_.size());
    nodes_.push_back({choice.split.value, choice.axis, {0, 0}});
    const auto middle = std::partition(points.begin(), points.end(),
                                       [&](const Point& p) { return p[choice.axis] < choice.split.value; });
    const std::int32_t left = grow({points.begin(), middle}, below, tiles_below);
    const std::int32_t right = grow({middle, points.end()}, above, tiles - tiles_below);
    nodes_[static_cast<std::size_t>(row)].child[0] = left;
    nodes_[static_cast<std::size_t>(row)].child[1] = right;
    return row;
  }

  // Chooses the longest axis. If ties move its split far from the wanted rank (by a quarter of the points) and another
  // axis does better, chooses that axis. axis < 0 when all points are equal.
  Choice split_points(std::span<Point> points, std::uint32_t tiles) const {
    if (points.size() < 2) return {};
    Bounds bounds;
    for (const Point& p : points) bounds.add(p);
    std::array<int, 3> axes{0, 1, 2};
    const auto end = axes.begin() + dimension_;
    std::stable_sort(axes.begin(), end,
                     [&](int a, int b) { return bounds.hi[a] - bounds.lo[a] > bounds.hi[b] - bounds.lo[b]; });
    const std::size_t rank = points.size() * (tiles / 2) / tiles;  // < 2^40 points, < 2^20 tiles
    Choice best;
    std::size_t best_error = points.size();
    for (auto axis = axes.begin(); axis != end; ++axis) {
      if (bounds.lo[*axis] == bounds.hi[*axis]) continue;
      const MedianSplit split = median_split(points, *axis, rank);
      const std::size_t error = split.below > rank ? split.below - rank : rank - split.below;
      if (best.axis < 0 || error < best_error) {
        best = {*axis, split};
        best_error = error;
      }
      if (best_error <= points.size() / 4) break;
    }
    return best;
  }

  // For boxes without different points: splits the axis with most doubles, in their middle.
  Choice split_box(const Box& box) const {
    int axis = 0;
    for (int a = 1; a < dimension_; ++a) {
      if (width(box.lo[a], box.hi[a]) > width(box.lo[axis], box.hi[axis])) axis = a;
    }
    const std::uint64_t half = width(box.lo[axis], box.hi[axis]) / 2;
    const auto middle = static_cast<std::int64_t>(static_cast<std::uint64_t>(ordinal(box.lo[axis])) + half);
    return {axis, {from_ordinal(middle), 0}};
  }

  // Returns the number of tiles for the lower side: in proportion to its points, but no more than the doubles in its
  // box allow.
  std::uint32_t share(std::size_t points, std::size_t points_below, const Box& below, const Box& above,
                      std::uint32_t tiles) const {
    const double part = points_below == 0 || points_below == points
                            ? 0.5
                            : static_cast<double>(points_below) / static_cast<double>(points);
    const auto wanted = static_cast<std::uint32_t>(std::lround(part * tiles));
    const std::uint32_t room_below = room(below, tiles);
    const std::uint32_t room_above = room(above, tiles);
    const std::uint32_t least = tiles > room_above ? std::max(1u, tiles - room_above) : 1u;
    return std::clamp(wanted, least, std::min(room_below, tiles - 1));
  }

  // Returns how many tiles the box can be cut into, at most `most`.
  std::uint32_t room(const Box& box, std::uint32_t most) const {
    std::uint64_t cells = 1;
    for (int a = 0; a < dimension_; ++a) {
      cells = std::min<std::uint64_t>(most, cells * std::min<std::uint64_t>(most, width(box.lo[a], box.hi[a])));
    }
    return static_cast<std::uint32_t>(cells);
  }

  int dimension_;
  std::vector<Point> sample_;
  std::vector<SplitNode> nodes_;
  std::uint32_t leaves_ = 0;
};

}  // namespace

std::vector<SplitNode> build_kd_tree(int dimension, std::vector<Point> sample, std::uint32_t tiles) {
  return KdBuilder(dimension, std::move(sample)).build(tiles);
}

}  // namespace tessera
