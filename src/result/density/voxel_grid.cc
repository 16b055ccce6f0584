#include "src/result/density/voxel_grid.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "src/base/option.h"

namespace tessera::density {
namespace {

// The limits of rasters of heights (src/result/terrain/grid.cc).
constexpr double position_max = 0x1p40, side_max = 1 << 24, all_max = 0x1p40;

}  // namespace

Result<VoxelGrid> voxels_over(int dimension, double res, const Bounds& box, const Bounds& vertices) {
  // Beyond these limits a double cannot hold the volume of a voxel.
  if (!(res > 1e-100 && res < 1e100))
    return error(Errc::usage, option("res") + ": must be the width of a pixel or voxel, finite and above 0");
  VoxelGrid grid{.dimension = dimension, .res = res};
  double farthest = 0, all = 1;
  for (int axis = 0; axis < dimension; ++axis) {
    if (!(box.lo[axis] < box.hi[axis]))
      return error(Errc::usage, option("bbox") + (dimension == 2 ? ": has no area" : ": has no volume"));
    for (const Bounds* bounds : {&box, &vertices})
      farthest = std::max({farthest, std::abs(bounds->lo[axis]), std::abs(bounds->hi[axis])});
  }
  if (!(farthest <= res * position_max))
    return error(Errc::usage,
                 option("res") + ": is too small for coordinates as large as these, or the box is too large");
  std::string sides;
  bool fits = true;
  for (int axis = 0; axis < dimension; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    grid.first[i] = grid.voxel_of(box.lo[axis]);
    grid.size[i] = grid.voxel_below(box.hi[axis]) - grid.first[i] + 1;
    all *= static_cast<double>(grid.size[i]);
    fits = fits && static_cast<double>(grid.size[i]) <= side_max;
    sides += (sides.empty() ? "" : " x ") + std::to_string(grid.size[i]);
  }
  if (!fits || all > all_max)
    return error(Errc::usage, "a grid of " + sides + (dimension == 2 ? " pixels" : " voxels") +
                                  " is too large: give a larger " + option("res") + ", or a smaller " + option("bbox"));
  return grid;
}

}  // namespace tessera::density
