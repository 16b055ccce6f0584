#include "src/result/density/voxel_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "src/base/option.h"
#include "src/base/periodic_box.h"

namespace tessera::density {
namespace {

// The limits of rasters of heights (src/result/terrain/grid.cc).
constexpr double position_max = 0x1p40, side_max = 1 << 24, all_max = 0x1p40;
// By how much of itself a width may miss a part of the period, because a user writes decimals.
constexpr double width_slack = 1e-9;
constexpr std::array<const char*, 3> axis_names{"x", "y", "z"};

// REQUIRES: |a| >= |b|, or a is 0.
GridPlane sum_in_order(double a, double b) {
  const double sum = a + b;
  return {sum, b - (sum - a)};
}

std::string text_of(double number) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.15g", number);
  return text.data();
}

const char* voxels_in(int dimension) { return dimension == 2 ? "pixels" : "voxels"; }

Status check_shape(const std::string& out, int dimension, const Period& period, const GridShape& shape) {
  const bool by_number = !shape.voxels.empty();
  // Beyond these limits a double cannot hold the volume of a voxel.
  if (!by_number && !(shape.res > 1e-100 && shape.res < 1e100))
    return error(Errc::usage, option("res") + ": must be the width of a pixel or voxel, finite and above 0");
  if (!by_number) return success();
  if (shape.res != 0)
    return error(Errc::usage, option("res") + " and " + option("grid") + " both say how large a " +
                                  (dimension == 2 ? "pixel" : "voxel") + " is; give one of them");
  if (shape.voxels.size() != 1 && shape.voxels.size() != static_cast<std::size_t>(dimension))
    return error(Errc::usage, option("grid") + ": has " + std::to_string(shape.voxels.size()) +
                                  " numbers, but takes 1, or one for each of the " + std::to_string(dimension) +
                                  " axes");
  for (const std::int64_t voxels : shape.voxels)
    if (voxels < 1 || static_cast<double>(voxels) > side_max)
      return error(Errc::usage, option("grid") + ": must be 1 to " +
                                    std::to_string(static_cast<std::int64_t>(side_max)) + " " + voxels_in(dimension) +
                                    " along an axis, not " + std::to_string(voxels));
  if (shape.box && period.any())
    return error(Errc::usage, out + ": is periodic, so " + option("grid") + " counts the " + voxels_in(dimension) +
                                  " of the whole period; with " + option("bbox") + ", give " + option("res"));
  return success();
}

// Voxels that fill the period `length`.
Result<VoxelAxis> periodic_axis(int axis, double length, double res) {
  const double parts = length / res, count = std::rint(parts);
  if (count > side_max)
    return error(Errc::usage, option("res") + ": is too small: the period has more than " +
                                  std::to_string(static_cast<std::int64_t>(side_max)) + " such parts");
  if (count < 1 || std::abs(parts - count) > width_slack * count) {
    const double fewer = std::max(1.0, std::floor(parts));
    return error(Errc::usage, option("res") + ": does not divide the period " + text_of(length) + " along " +
                                  axis_names[static_cast<std::size_t>(axis)] + "; the next widths that do are " +
                                  text_of(length / fewer) + " and " + text_of(length / (fewer + 1)) + ", or give " +
                                  option("grid"));
  }
  return VoxelAxis{.origin = 0, .length = length, .count = static_cast<std::int64_t>(count), .periodic = true};
}

Result<VoxelAxis> axis_of(int axis, const Period& period, const GridShape& shape, const Bounds& box) {
  const std::size_t i = static_cast<std::size_t>(axis);
  const double length = period.length[i];
  if (shape.voxels.empty()) {
    if (length > 0) return periodic_axis(axis, length, shape.res);
    return VoxelAxis{.origin = 0, .length = shape.res, .count = 1, .periodic = false};
  }
  const std::int64_t count = shape.voxels[shape.voxels.size() == 1 ? 0 : i];
  if (length > 0) return VoxelAxis{.origin = 0, .length = length, .count = count, .periodic = true};
  VoxelAxis made{.origin = box.lo[axis], .length = box.hi[axis] - box.lo[axis], .count = count, .periodic = false};
  // The last plane must not be below the box, whose side was rounded.
  if (made.plane(count).below(box.hi[axis]) > 0)
    made.length = std::nextafter(made.length, std::numeric_limits<double>::infinity());
  return made;
}

}  // namespace

GridPlane VoxelAxis::plane(std::int64_t i) const {
  const auto number = static_cast<double>(i);
  const double product = number * length;
  GridPlane plane{product, std::fma(number, length, -product)};
  if (count > 1) {
    const auto parts = static_cast<double>(count);
    const double quotient = plane.at / parts;
    plane = sum_in_order(quotient, (std::fma(-quotient, parts, plane.at) + plane.rest) / parts);
  }
  if (origin == 0) return plane;
  const double sum = origin + plane.at, part = sum - origin;
  return sum_in_order(sum, ((origin - (sum - part)) + (plane.at - part)) + plane.rest);
}

double VoxelAxis::centre(std::int64_t i) const {
  const auto within = [&](std::int64_t voxel) {
    return (static_cast<double>(voxel) + 0.5) * length / static_cast<double>(count);
  };
  if (!periodic) return origin + within(i);
  const std::int64_t voxel = (i % count + count) % count;
  const double step = step_of(length);
  return std::rint(within(voxel) / step) * step + static_cast<double>((i - voxel) / count) * length;
}

bool VoxelGrid::find(std::array<std::int64_t, 3>& voxel) const {
  for (std::size_t axis = 0; axis < static_cast<std::size_t>(dimension); ++axis) {
    std::int64_t from_first = voxel[axis] - first[axis];
    if (axes[axis].periodic) from_first = (from_first % axes[axis].count + axes[axis].count) % axes[axis].count;
    if (from_first < 0 || from_first >= size[axis]) return false;
    voxel[axis] = first[axis] + from_first;
  }
  return true;
}

std::optional<double> VoxelGrid::res() const {
  for (int axis = 1; axis < dimension; ++axis)
    if (axes[static_cast<std::size_t>(axis)].width() != axes[0].width()) return std::nullopt;
  return axes[0].width();
}

Result<VoxelGrid> voxels_over(const std::string& out, int dimension, const Period& period, const GridShape& shape,
                              const Bounds& vertices) {
  BOOST_OUTCOME_TRYV(check_shape(out, dimension, period, shape));
  VoxelGrid grid{.dimension = dimension};
  const Bounds box = shape.box.value_or(vertices);
  const std::string size_option = option(shape.voxels.empty() ? "res" : "grid");
  double all = 1;
  std::string sides;
  bool fits = true;
  for (int axis = 0; axis < dimension; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    const bool whole_period = period.along(axis) && !shape.box;
    if (!whole_period && !(box.lo[axis] < box.hi[axis]))
      return error(Errc::usage, option("bbox") + (dimension == 2 ? ": has no area" : ": has no volume"));
    BOOST_OUTCOME_TRY(made, axis_of(axis, period, shape, box));
    grid.axes[i] = made;
    double farthest = 0;
    for (const Bounds* bounds : {&box, &vertices})
      farthest =
          std::max({farthest, std::abs(bounds->lo[axis] - made.origin), std::abs(bounds->hi[axis] - made.origin)});
    if (!(farthest <= made.width() * position_max))
      return error(Errc::usage,
                   size_option + ": is too small for coordinates as large as these, or the box is too large");
    grid.first[i] = whole_period ? 0 : made.voxel_of(box.lo[axis]);
    grid.size[i] = whole_period ? made.count : made.voxel_below(box.hi[axis]) - grid.first[i] + 1;
    if (made.periodic && grid.size[i] > made.count)
      return error(Errc::usage, option("bbox") + ": is longer than the period along " + axis_names[i] + ", " +
                                    text_of(made.length) + ", in whole " + voxels_in(dimension));
    all *= static_cast<double>(grid.size[i]);
    fits = fits && static_cast<double>(grid.size[i]) <= side_max;
    sides += (sides.empty() ? "" : " x ") + std::to_string(grid.size[i]);
  }
  if (!fits || all > all_max)
    return error(Errc::usage, "a grid of " + sides + " " + voxels_in(dimension) + " is too large: give a " +
                                  (shape.voxels.empty() ? "larger " : "smaller ") + size_option + ", or a smaller " +
                                  option("bbox"));
  return grid;
}

}  // namespace tessera::density
