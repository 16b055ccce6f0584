// What each voxel gets of a cell.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

#include "src/base/point.h"
#include "src/result/density/voxel_grid.h"

namespace tessera::density {

// The part of a cell in a voxel. The integral over this part of a function that is linear in the cell is the sum of the
// weights times the values at the cell's vertices, times a volume: of the whole cell, or of a voxel.
struct CellShare {
  std::array<std::int64_t, 3> at{};  // the voxel, counted as the grid's `first`
  std::array<double, 4> weights{};   // of the cell's vertices
  bool of_voxel = false;             // the volume is that of a voxel
};
// Returns false when no more shares are wanted.
using TakeShare = std::function<bool(const CellShare&)>;

// Calls `take` for each voxel of the grid that the cell meets; along a periodic axis the cell stands for all of its
// copies, and a voxel may come several times. `corners` are the cell's d + 1 vertices, positively
// oriented or not. The bits of a share depend only on the corners with their order, on the voxel, and on the width of
// voxels. A part is right to some 2^-46 of the volume of the cell or of a voxel, whichever is less, however flat the
// cell is; and the parts of a cell add up to the cell to the same accuracy. A part that only touches a voxel may come
// as one of almost no volume. The finer the grid for the cell, the more bits the computation takes.
void mean_shares(const VoxelGrid& grid, std::span<const Point> corners, const TakeShare& take);

// Calls `take` for each voxel of the grid whose centre is in the cell: then the weights are those of the linear
// function at the centre, right to 1e-14. A centre on the face of a cell belongs to the cell into which it moves by an
// infinitely small step to greater x, one infinitely smaller to greater y, and one smaller still to greater z. So
// exactly one cell has each centre within the hull, as in rasters of heights. REQUIRES: the corners are positively
// oriented in the order `oriented`, a permutation of 0..d.
void sample_shares(const VoxelGrid& grid, std::span<const Point> corners, std::span<const std::uint8_t> oriented,
                   const TakeShare& take);

}  // namespace tessera::density
