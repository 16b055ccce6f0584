// An octree (a quadtree in 2D): equal cubes, split where the points are.
#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <utility>

#include "src/tiling/split_tree.h"

namespace tessera {
namespace {

constexpr int levels_max = 40;  // two far clusters must not cost a level per factor 2 of their distance

struct Cube {
  Point lo, hi;  // what is halved; the outer boxes of the tree are unbounded all the same
  std::span<Point> points;
  int level = 0;
  std::int32_t parent = -1;  // the row and side of the tree from which this leaf hangs
  int side = 0;
};

class OctreeBuilder {
 public:
  OctreeBuilder(int dimension, std::vector<Point> sample, const Bounds& bounds)
      : dimension_(dimension), sample_(std::move(sample)) {
    root_.points = sample_;
    const Bounds used = bounds.empty() ? Bounds{{0, 0, 0}, {0, 0, 0}} : bounds;
    double half = 0;
    double largest = 0;
    for (int a = 0; a < dimension; ++a) {
      half = std::max(half, used.hi[a] / 2 - used.lo[a] / 2);
      largest = std::max({largest, std::abs(used.lo[a]), std::abs(used.hi[a])});
    }
    // Wide enough for 20 halvings between doubles of this size.
    half = std::max({half, std::ldexp(largest, -28), std::ldexp(1.0, -1000)});
    for (int a = 0; a < dimension; ++a) {
      const double center = midpoint(used.lo[a], used.hi[a]);
      root_.lo[a] = std::max(center - half, std::numeric_limits<double>::lowest());
      root_.hi[a] = std::min(center + half, std::numeric_limits<double>::max());
    }
  }

  std::vector<SplitNode> by_limit(std::size_t limit, std::uint32_t leaves_max) {
    std::vector<Cube> leaves;
    std::queue<Cube> todo;  // by level, so that no corner stays unsplit when leaves_max is reached
    todo.push(root_);
    const std::size_t children = std::size_t{1} << dimension_;
    while (!todo.empty()) {
      const Cube cube = todo.front();
      todo.pop();
      if (cube.points.size() > limit && leaves.size() + todo.size() + children <= leaves_max && splittable(cube)) {
        for (Cube& child : split(cube)) todo.push(child);
      } else {
        leaves.push_back(cube);
      }
    }
    return finish(leaves);
  }

  std::vector<SplitNode> by_tiles(std::uint32_t tiles) {
    // The fullest leaf first; of equally full leaves the largest, then the oldest.
    const auto after = [](const Entry& a, const Entry& b) {
      if (a.cube.points.size() != b.cube.points.size()) return a.cube.points.size() < b.cube.points.size();
      if (a.cube.level != b.cube.level) return a.cube.level > b.cube.level;
      return a.order > b.order;
    };
    std::priority_queue<Entry, std::vector<Entry>, decltype(after)> todo(after);
    std::size_t order = 0;
    todo.push({root_, order++});
    std::vector<Cube> leaves;
    while (!todo.empty() && leaves.size() + todo.size() < tiles) {
      const Cube cube = todo.top().cube;
      todo.pop();
      if (splittable(cube)) {
        for (Cube& child : split(cube)) todo.push({child, order++});
      } else {
        leaves.push_back(cube);
      }
    }
    for (; !todo.empty(); todo.pop()) leaves.push_back(todo.top().cube);
    return finish(leaves);
  }

 private:
  struct Entry {
    Cube cube;
    std::size_t order;
  };

  bool splittable(const Cube& cube) const {
    if (cube.level >= levels_max) return false;
    for (int a = 0; a < dimension_; ++a) {
      const double middle = midpoint(cube.lo[a], cube.hi[a]);
      if (!(cube.lo[a] < middle && middle < cube.hi[a])) return false;
    }
    return true;
  }

  // Splits by one plane after the other: 2^d leaves hang from 2^d - 1 rows.
  std::vector<Cube> split(const Cube& cube) {
    std::vector<Cube> parts{cube};
    for (int a = 0; a < dimension_; ++a) {
      const double middle = midpoint(cube.lo[a], cube.hi[a]) + 0.0;
      std::vector<Cube> halves;
      for (const Cube& part : parts) {
        const auto row = static_cast<std::int32_t>(nodes_.size());
        nodes_.push_back({middle, a, {0, 0}});
        hang(part, row);
        const auto border =
            std::partition(part.points.begin(), part.points.end(), [&](const Point& p) { return p[a] < middle; });
        Cube below = part;
        Cube above = part;
        below.hi[a] = middle;
        above.lo[a] = middle;
        below.points = {part.points.begin(), border};
        above.points = {border, part.points.end()};
        below.parent = above.parent = row;
        below.side = 0;
        above.side = 1;
        halves.push_back(below);
        halves.push_back(above);
      }
      parts = std::move(halves);
    }
    for (Cube& part : parts) ++part.level;
    return parts;
  }

  void hang(const Cube& cube, std::int32_t child) {
    if (cube.parent >= 0) nodes_[static_cast<std::size_t>(cube.parent)].child[cube.side] = child;
  }

  // Numbers the leaves in the order of the tree, so that near tiles have near numbers.
  std::vector<SplitNode> finish(const std::vector<Cube>& leaves) {
    for (const Cube& leaf : leaves) hang(leaf, as_leaf(TileId{0}));
    if (nodes_.empty()) return {};
    std::uint32_t number = 0;
    std::vector<std::pair<std::int32_t, int>> todo{{0, 1}, {0, 0}};
    while (!todo.empty()) {
      const auto [row, side] = todo.back();
      todo.pop_back();
      std::int32_t& child = nodes_[static_cast<std::size_t>(row)].child[side];
      if (child < 0) {
        child = as_leaf(TileId{number++});
      } else {
        todo.emplace_back(child, 1);
        todo.emplace_back(child, 0);
      }
    }
    return std::move(nodes_);
  }

  int dimension_;
  std::vector<Point> sample_;
  Cube root_;
  std::vector<SplitNode> nodes_;
};

}  // namespace

std::vector<SplitNode> build_octree(int dimension, std::vector<Point> sample, const Bounds& bounds, std::size_t limit,
                                    std::uint32_t leaves_max) {
  return OctreeBuilder(dimension, std::move(sample), bounds).by_limit(limit, leaves_max);
}

std::vector<SplitNode> build_octree_tiles(int dimension, std::vector<Point> sample, const Bounds& bounds,
                                          std::uint32_t tiles) {
  return OctreeBuilder(dimension, std::move(sample), bounds).by_tiles(tiles);
}

}  // namespace tessera
