#include "src/tiling/split_tree.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

namespace tessera {

std::vector<Box> boxes_of(std::span<const SplitNode> nodes, std::uint32_t leaves) {
  std::vector<Box> boxes(leaves);
  if (nodes.empty()) return boxes;
  std::vector<std::pair<std::int32_t, Box>> todo{{0, Box{}}};
  while (!todo.empty()) {
    const auto [row, box] = todo.back();
    todo.pop_back();
    if (row < 0) {
      boxes[tile_at(row).value] = box;
      continue;
    }
    const SplitNode& node = nodes[static_cast<std::size_t>(row)];
    Box below = box;
    Box above = box;
    below.hi[node.axis] = node.value;
    above.lo[node.axis] = node.value;
    todo.emplace_back(node.child[0], below);
    todo.emplace_back(node.child[1], above);
  }
  return boxes;
}

// IEEE doubles are sign and magnitude: positive doubles already sort as integers, negative ones in reverse.
std::int64_t ordinal(double x) {
  const auto bits = std::bit_cast<std::int64_t>(x);
  return bits >= 0 ? bits : std::numeric_limits<std::int64_t>::min() - bits;
}

double from_ordinal(std::int64_t n) {
  return std::bit_cast<double>(n >= 0 ? n : std::numeric_limits<std::int64_t>::min() - n);
}

MedianSplit median_split(std::span<Point> points, int axis, std::size_t rank) {
  const auto by_axis = [axis](const Point& a, const Point& b) { return a[axis] < b[axis]; };
  const auto nth = points.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(points.begin(), nth, points.end(), by_axis);
  const double at = (*nth)[axis];
  // Points that are equal to the median on this axis go to one side together: the plane is at their value, or at the
  // next higher one.
  const auto below =
      static_cast<std::size_t>(std::count_if(points.begin(), nth, [&](const Point& p) { return p[axis] < at; }));
  std::size_t up_to = rank;
  double next = std::numeric_limits<double>::infinity();
  for (auto p = nth; p != points.end(); ++p) {
    if ((*p)[axis] == at) {
      ++up_to;
    } else {
      next = std::min(next, (*p)[axis]);
    }
  }
  const bool next_exists = up_to < points.size();
  if (next_exists && (below == 0 || up_to - rank < rank - below)) return {next, up_to};
  return {at, below};
}

double midpoint(double lo, double hi) {
  const double span = hi - lo;
  return std::isfinite(span) ? lo + span / 2 : lo / 2 + hi / 2;
}

}  // namespace tessera
