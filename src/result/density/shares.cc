#include "src/result/density/shares.h"

#include <algorithm>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cmath>
#include <functional>
#include <optional>
#include <vector>

#include "src/result/density/clip.h"
#include "src/result/density/linear.h"

namespace tessera::density {
namespace {

// With n voxels along a cell, a corner of a shape is right to n rounding errors, in units of a voxel.
using Fine =
    boost::multiprecision::number<boost::multiprecision::cpp_bin_float<128, boost::multiprecision::digit_base_2>,
                                  boost::multiprecision::et_off>;
constexpr std::int64_t double_max = 16, long_double_max = 1 << 14;

struct VoxelRange {
  std::int64_t from = 0, to = 0;  // both included
};
using VoxelRanges = std::array<VoxelRange, 3>;

// The voxels that the interior of the cell's bounds meets, also outside of the grid.
VoxelRanges around(const VoxelGrid& grid, std::span<const Point> corners) {
  VoxelRanges ranges;
  for (int axis = 0; axis < grid.dimension; ++axis) {
    double lo = corners[0][axis], hi = lo;
    for (const Point& p : corners) {
      lo = std::min(lo, p[axis]);
      hi = std::max(hi, p[axis]);
    }
    const VoxelAxis& line = grid.axes[static_cast<std::size_t>(axis)];
    const std::int64_t from = line.voxel_of(lo);
    ranges[static_cast<std::size_t>(axis)] = {from, std::max(from, line.voxel_below(hi))};
  }
  return ranges;
}

std::int64_t floored_quotient(std::int64_t a, std::int64_t b) { return a / b - (a % b < 0 ? 1 : 0); }

// What of the ranges is in the grid; nothing when that is empty. Along a periodic axis voxels between two copies of the
// grid are left in.
std::optional<VoxelRanges> within(const VoxelGrid& grid, VoxelRanges ranges) {
  for (std::size_t axis = 0; axis < static_cast<std::size_t>(grid.dimension); ++axis) {
    VoxelRange& range = ranges[axis];
    const std::int64_t first = grid.first[axis], last = first + grid.size[axis] - 1;
    std::int64_t least_copy = 0, greatest_copy = 0;  // of the grid
    if (const std::int64_t period = grid.axes[axis].periodic ? grid.axes[axis].count : 0; period > 0) {
      least_copy = -floored_quotient(last - range.from, period);
      greatest_copy = floored_quotient(range.to - first, period);
      least_copy *= period;
      greatest_copy *= period;
    }
    range.from = std::max(range.from, first + least_copy);
    range.to = std::min(range.to, last + greatest_copy);
    if (range.from > range.to) return std::nullopt;
  }
  return ranges;
}

// Cuts a cell along one axis after the other. The parts of a cut are made of the part before it alone, so that a voxel
// far along the axis is as accurate as the first.
template <class Number, template <class> class Shape>
class Slicer {
 public:
  static constexpr std::size_t corners = Shape<Number>::corners, d = corners - 1;

  Slicer(const VoxelGrid& grid, std::span<const Point> cell, const VoxelRanges& all, const VoxelRanges& wanted,
         const TakeShare& take)
      : grid_(grid), cell_(cell), all_(all), wanted_(wanted), take_(take) {
    // Only a cell that is at least three voxels wide has a whole voxel inside.
    bool wide = true;
    for (std::size_t axis = 0; axis < d; ++axis) wide = wide && all[axis].to - all[axis].from >= 2;
    if (wide) inside_.emplace(grid, cell, std::array{all[0].from, all[1].from, all[2].from});
  }

  void cut() { cut(0, Shape<Number>::whole()); }

 private:
  void cut(std::size_t axis, const Shape<Number>& shape) {
    const VoxelRange reach = reach_of(axis, shape);
    const std::int64_t from = std::max(reach.from, wanted_[axis].from), to = std::min(reach.to, wanted_[axis].to);
    for (std::int64_t i = from; i <= to && wanted_more_; ++i) {
      share_.at[axis] = i;
      if (axis + 1 == d && inside_ && inside_->has_voxel(share_.at)) {
        share_.of_voxel = true;
        share_.weights = inside_->weights(share_.at);
        wanted_more_ = take_(share_);
        continue;
      }
      if (reach.from == reach.to) {
        next(axis, shape);
        continue;
      }
      Shape<Number> part = shape;
      if (i > reach.from) part.clip(distances(axis, i), true);
      if (i < reach.to) part.clip(distances(axis, i + 1), false);
      if (!part.empty()) next(axis, part);
    }
  }

  void next(std::size_t axis, const Shape<Number>& part) {
    if (axis + 1 < d) return cut(axis + 1, part);
    const auto integrals = part.integrals();
    share_.of_voxel = false;
    for (std::size_t k = 0; k < corners; ++k) share_.weights[k] = static_cast<double>(integrals[k]);
    wanted_more_ = take_(share_);
  }

  Weights<Number, corners> distances(std::size_t axis, std::int64_t i) const {
    const GridPlane plane = grid_.axes[axis].plane(i);
    Weights<Number, corners> made;
    for (std::size_t k = 0; k < corners; ++k)
      made[k] = (Number(cell_[k][static_cast<int>(axis)]) - Number(plane.at)) - Number(plane.rest);
    return made;
  }

  // The voxels that the shape meets, or some more beside: its corners are rounded.
  VoxelRange reach_of(std::size_t axis, const Shape<Number>& shape) const {
    const VoxelRange& all = all_[axis];
    if (all.from == all.to) return all;
    constexpr double slack = 0x1p-20;
    const double width = grid_.axes[axis].width();
    const auto distance = distances(axis, all.from);
    double lo = 0, hi = 0;
    bool first = true;
    for (const auto& point : shape.points()) {
      const double at = static_cast<double>(mean_of(point, distance)) / width;
      lo = first ? at : std::min(lo, at);
      hi = first ? at : std::max(hi, at);
      first = false;
    }
    const auto voxel = [&](double at) {
      return std::clamp(all.from + static_cast<std::int64_t>(std::floor(at)), all.from, all.to);
    };
    return {voxel(lo - slack), voxel(hi + slack)};
  }

  const VoxelGrid& grid_;
  std::span<const Point> cell_;
  const VoxelRanges &all_, &wanted_;
  const TakeShare& take_;
  std::optional<VoxelWeights> inside_;
  CellShare share_;
  bool wanted_more_ = true;
};

template <class Number>
void slice(const VoxelGrid& grid, std::span<const Point> corners, const VoxelRanges& all, const VoxelRanges& wanted,
           const TakeShare& take) {
  if (corners.size() == 3)
    Slicer<Number, Polygon>(grid, corners, all, wanted, take).cut();
  else
    Slicer<Number, Polyhedron>(grid, corners, all, wanted, take).cut();
}

// Takes shares in all of space, and gives `take` those of the grid, as voxels of the grid.
TakeShare in_grid(const VoxelGrid& grid, const TakeShare& take) {
  if (!grid.periodic()) return std::ref(take);
  return [&grid, &take](const CellShare& share) {
    CellShare moved = share;
    return !grid.find(moved.at) || take(moved);
  };
}

}  // namespace

void mean_shares(const VoxelGrid& grid, std::span<const Point> corners, const TakeShare& take_in_grid) {
  const TakeShare take = in_grid(grid, take_in_grid);
  const VoxelRanges all = around(grid, corners);
  const auto wanted = within(grid, all);
  if (!wanted) return;
  std::int64_t longest = 1;
  for (const VoxelRange& range : all) longest = std::max(longest, range.to - range.from + 1);
  if (longest == 1) {  // most cells of a fine cloud
    CellShare share;
    for (std::size_t axis = 0; axis < corners.size() - 1; ++axis) share.at[axis] = all[axis].from;
    std::fill_n(share.weights.begin(), corners.size(), 1 / static_cast<double>(corners.size()));
    take(share);
    return;
  }
  if (longest <= double_max)
    slice<double>(grid, corners, all, *wanted, take);
  else if (longest <= long_double_max)
    slice<long double>(grid, corners, all, *wanted, take);
  else
    slice<Fine>(grid, corners, all, *wanted, take);
}

void sample_shares(const VoxelGrid& grid, std::span<const Point> corners, std::span<const std::uint8_t> oriented,
                   const TakeShare& take_in_grid) {
  const TakeShare take = in_grid(grid, take_in_grid);
  VoxelRanges ranges = around(grid, corners);
  for (std::size_t axis = 0; axis + 1 < corners.size(); ++axis) {
    // A rounded centre may be on the plane between two voxels.
    --ranges[axis].from;
    ++ranges[axis].to;
  }
  const auto wanted = within(grid, ranges);
  if (!wanted) return;
  const CellAtPoint cell(corners, oriented);
  CellShare share{.of_voxel = true};
  Point centre;
  const auto [x, y, z] = *wanted;
  for (share.at[2] = z.from; share.at[2] <= z.to; ++share.at[2]) {
    if (grid.dimension == 3) centre.z = grid.axes[2].centre(share.at[2]);
    for (share.at[1] = y.from; share.at[1] <= y.to; ++share.at[1]) {
      centre.y = grid.axes[1].centre(share.at[1]);
      for (share.at[0] = x.from; share.at[0] <= x.to; ++share.at[0]) {
        centre.x = grid.axes[0].centre(share.at[0]);
        if (!cell.has(centre)) continue;
        share.weights = cell.weights(centre);
        if (!take(share)) return;
      }
    }
  }
}

}  // namespace tessera::density
