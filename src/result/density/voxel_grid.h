// Where the pixels of an image, or the voxels of a volume, are. Below, a pixel is a voxel of a 2D grid.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <string_view>

#include "src/base/point.h"
#include "src/base/result.h"

namespace tessera::density {

// A plane between voxels: the coordinate at + rest, without rounding.
struct GridPlane {
  double at = 0, rest = 0;
  // The coordinate's distance from the plane, rounded; its sign is right.
  double below(double coordinate) const { return (coordinate - at) - rest; }
};

// A part of the one grid of voxels of width `res` that covers space. Voxel i of an axis reaches from i * res to
// (i + 1) * res, without rounding, so all voxels have the same volume. As in rasters of heights, two grids with the
// same width share the voxels that both have.
struct VoxelGrid {
  int dimension = 3;
  double res = 1;                             // the width of a voxel, in units of the coordinates
  std::array<std::int64_t, 3> first{};        // the first voxel on each axis
  std::array<std::int64_t, 3> size{1, 1, 1};  // in voxels; in 2D size[2] is 1

  GridPlane plane(std::int64_t i) const {
    const auto number = static_cast<double>(i);
    const double at = number * res;
    return {at, std::fma(number, res, -at)};
  }
  // The voxel of a coordinate: plane(i) <= coordinate < plane(i + 1).
  std::int64_t voxel_of(double coordinate) const {
    auto i = static_cast<std::int64_t>(std::floor(coordinate / res));
    while (plane(i).below(coordinate) < 0) --i;
    while (plane(i + 1).below(coordinate) >= 0) ++i;
    return i;
  }
  // The voxel below a coordinate: plane(i) < coordinate <= plane(i + 1).
  std::int64_t voxel_below(double coordinate) const {
    const std::int64_t i = voxel_of(coordinate);
    return plane(i).below(coordinate) == 0 ? i - 1 : i;
  }
  // The coordinate of the voxel's centre, rounded once.
  double centre(std::int64_t i) const { return (static_cast<double>(i) + 0.5) * res; }
  std::int64_t voxels() const { return size[0] * size[1] * size[2]; }
};

// Returns all voxels that meet the interior of `box`. `vertices` has the bounds of all vertices. Error usage: `res` is
// not finite, not above 0, or too small; the box is empty; the grid has too many voxels.
Result<VoxelGrid> voxels_over(int dimension, double res, const Bounds& box, const Bounds& vertices);

}  // namespace tessera::density
