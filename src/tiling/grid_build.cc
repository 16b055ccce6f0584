// A regular grid, as a balanced tree over its planes. So the code that looks up a box is the same for all kinds.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "src/tiling/split_tree.h"

namespace tessera {
namespace {

using Counts = std::array<std::uint32_t, 3>;

// Returns the boxes per axis: the most cubic boxes whose number is between tiles and 1.25 * tiles.
Counts boxes_per_axis(int dimension, const Bounds& bounds, std::uint32_t tiles) {
  std::array<double, 3> side{};
  double longest = 0;
  for (int a = 0; a < dimension; ++a) {
    side[a] = bounds.hi[a] / 4 - bounds.lo[a] / 4;  // a quarter: cannot overflow, nor can sums of three
    longest = std::max(longest, side[a]);
  }
  // Relative sides; a flat axis counts as nearly flat, so that it is not cut unless all are flat.
  for (int a = 0; a < dimension; ++a) side[a] = longest > 0 ? std::max(side[a] / longest, 1e-9) : 1;
  if (dimension == 2) side[2] = 1;

  const auto most = static_cast<std::uint32_t>(std::min<std::uint64_t>(std::uint64_t{tiles} * 5 / 4, tiles + 1000000));
  Counts best{tiles, 1, 1};
  double best_cost = std::numeric_limits<double>::infinity();
  for (std::uint32_t nx = 1; nx <= most; ++nx) {
    for (std::uint32_t ny = 1; ny <= most / nx; ++ny) {
      const std::uint32_t nz = (tiles + nx * ny - 1) / (nx * ny);
      if (dimension == 2 ? nz > 1 : std::uint64_t{nx} * ny * nz > most) continue;
      const double x = side[0] / nx;
      const double y = side[1] / ny;
      const double z = side[2] / nz;
      // What a box has in common with other boxes, relative to its volume: least for cubes. Of equal costs, fewer boxes
      // win.
      const double cost =
          dimension == 2 ? (x + y) / std::sqrt(x * y) : (x * y + y * z + z * x) / std::cbrt(x * y * z * x * y * z);
      const std::uint64_t boxes = std::uint64_t{nx} * ny * nz;
      const std::uint64_t best_boxes = std::uint64_t{best[0]} * best[1] * best[2];
      if (cost < best_cost * (1 - 1e-9) || (cost <= best_cost * (1 + 1e-9) && boxes < best_boxes)) {
        best = {nx, ny, nz};
        best_cost = std::min(cost, best_cost);
      }
    }
  }
  return best;
}

std::vector<double> planes(double lo, double hi, std::uint32_t boxes) {
  std::vector<double> at(boxes - 1);
  for (std::uint32_t i = 1; i < boxes; ++i) {
    const double t = static_cast<double>(i) / boxes;
    at[i - 1] = lo * (1 - t) + hi * t + 0.0;
  }
  // So few doubles are between lo and hi that planes coincide. Consecutive doubles are taken instead.
  if (!std::is_sorted(at.begin(), at.end(), std::less_equal<>())) {
    const std::int64_t last = ordinal(std::numeric_limits<double>::max()) - static_cast<std::int64_t>(boxes);
    const std::int64_t first = std::min(ordinal(lo), last);
    for (std::uint32_t i = 1; i < boxes; ++i) at[i - 1] = from_ordinal(first + i);
  }
  return at;
}

class GridBuilder {
 public:
  GridBuilder(int dimension, const Bounds& bounds, const Counts& counts) : counts_(counts) {
    for (int a = 0; a < dimension; ++a) planes_[a] = planes(bounds.lo[a], bounds.hi[a], counts[a]);
  }

  std::vector<SplitNode> build() {
    grow({0, 0, 0}, counts_);
    return std::move(nodes_);
  }

 private:
  // Adds the block of boxes from..to (exclusive) on each axis, and returns its row. Halves it along the axis with most
  // boxes.
  std::int32_t grow(const Counts& from, const Counts& to) {
    int axis = 0;
    for (int a = 1; a < 3; ++a) {
      if (to[a] - from[a] > to[axis] - from[axis]) axis = a;
    }
    if (to[axis] - from[axis] == 1) return as_leaf(TileId{leaves_++});
    const std::uint32_t middle = from[axis] + (to[axis] - from[axis]) / 2;
    const auto row = static_cast<std::int32_t>(nodes_.size());
    nodes_.push_back({planes_[axis][middle - 1], axis, {0, 0}});
    Counts end = to;
    Counts begin = from;
    end[axis] = middle;
    begin[axis] = middle;
    const std::int32_t left = grow(from, end);
    const std::int32_t right = grow(begin, to);
    nodes_[static_cast<std::size_t>(row)].child[0] = left;
    nodes_[static_cast<std::size_t>(row)].child[1] = right;
    return row;
  }

  Counts counts_;
  std::array<std::vector<double>, 3> planes_;
  std::vector<SplitNode> nodes_;
  std::uint32_t leaves_ = 0;
};

}  // namespace

std::vector<SplitNode> build_grid(int dimension, const Bounds& bounds, std::uint32_t tiles) {
  const Bounds used = bounds.empty() ? Bounds{{0, 0, 0}, {0, 0, 0}} : bounds;
  return GridBuilder(dimension, used, boxes_per_axis(dimension, used, tiles)).build();
}

}  // namespace tessera
