// Where the pixels of an image, or the voxels of a volume, are. Below, a pixel is a voxel of a 2D grid.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "src/base/image.h"
#include "src/base/point.h"
#include "src/base/result.h"
#include "src/result/measure/scaled_double.h"

namespace tessera::density {

// A plane between voxels: the coordinate at + rest.
struct GridPlane {
  double at = 0, rest = 0;
  // The coordinate's distance from the plane, rounded; its sign is right.
  double below(double coordinate) const { return (coordinate - at) - rest; }
};

// The voxels along one axis. Voxel i reaches from origin + i * length / count to origin + (i + 1) * length / count.
// Planes are rounded to 2^-104 of themselves. So planes i * length are exact; and so are those that are coordinates of
// a periodic cloud, because other coordinates of the cloud are 2^-75 of the period away, or farther.
struct VoxelAxis {
  double origin = 0;
  double length = 1;
  std::int64_t count = 1;
  bool periodic = false;  // `length` is the period, and voxels i and i + count are the same

  double width() const { return length / static_cast<double>(count); }
  ScaledDouble exact_width() const {
    return count == 1 ? ScaledDouble::of(length)
                      : ScaledDouble::of(length) / ScaledDouble::of(static_cast<double>(count));
  }
  GridPlane plane(std::int64_t i) const;
  // The voxel of a coordinate: plane(i) <= coordinate < plane(i + 1).
  std::int64_t voxel_of(double coordinate) const {
    auto i = static_cast<std::int64_t>(std::floor((coordinate - origin) / width()));
    while (plane(i).below(coordinate) < 0) --i;
    while (plane(i + 1).below(coordinate) >= 0) ++i;
    return i;
  }
  // The voxel below a coordinate: plane(i) < coordinate <= plane(i + 1).
  std::int64_t voxel_below(double coordinate) const {
    const std::int64_t i = voxel_of(coordinate);
    return plane(i).below(coordinate) == 0 ? i - 1 : i;
  }
  // The coordinate of the voxel's centre, rounded. Along a periodic axis the centres of voxels i and i + count differ
  // by the period exactly.
  double centre(std::int64_t i) const;
};

// The voxels of a grid: `size` of them along each axis, from the voxels `first` on. Without a count of voxels, voxel i
// of an axis reaches from i * res to (i + 1) * res, without rounding. As in rasters of heights, two grids with the same
// width share the voxels that both have.
struct VoxelGrid {
  int dimension = 3;
  std::array<VoxelAxis, 3> axes{};
  std::array<std::int64_t, 3> first{};        // the first voxel on each axis
  std::array<std::int64_t, 3> size{1, 1, 1};  // in voxels; in 2D size[2] is 1

  std::int64_t voxels() const { return size[0] * size[1] * size[2]; }
  ScaledDouble voxel_volume() const {
    ScaledDouble volume = ScaledDouble::of(1);
    for (std::size_t axis = 0; axis < static_cast<std::size_t>(dimension); ++axis)
      volume = volume * axes[axis].exact_width();
    return volume;
  }
  bool periodic() const { return axes[0].periodic || axes[1].periodic || axes[2].periodic; }
  // Moves a voxel by whole periods to the grid. Returns false when the grid does not have the voxel.
  bool find(std::array<std::int64_t, 3>& voxel) const;
  // The width of voxels, if that is the same along all axes.
  std::optional<double> res() const;
};

// What grid is asked for: the width of voxels or their number.
struct GridShape {
  double res = 0;                            // in units of the coordinates; 0: by number
  std::vector<std::int64_t> voxels = {};     // one number for all axes, or one for each; empty: by width
  std::optional<Bounds> box = std::nullopt;  // default: the period, and the bounds of the vertices on axes without one
};

// By width: all voxels that meet the interior of the box. Along a periodic axis the voxels fill the period: `res` must
// be the period divided by a whole number, but for 1e-9 of itself, and voxels have exactly this width. By number: so
// many voxels fill the box. `vertices` has the bounds of all vertices of the result `out`. Error usage: wrong options;
// the box is empty, or along a periodic axis longer than the period, in whole voxels; too many voxels.
Result<VoxelGrid> voxels_over(const std::string& out, int dimension, const Period& period, const GridShape& shape,
                              const Bounds& vertices);

}  // namespace tessera::density
