// The linear functions of a cell that are 1 at one vertex and 0 at the others: the weights of its vertices at a place.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "src/base/point.h"
#include "src/result/density/voxel_grid.h"
#include "src/result/measure/scaled_double.h"

namespace tessera::density {

// The weights at the centres of the voxels of a grid. The functions are found with 512 bits, so that a flat cell has
// right ones.
class VoxelWeights {
 public:
  // `base` is a voxel of the cell's bounds, from which the others are counted.
  VoxelWeights(const VoxelGrid& grid, std::span<const Point> corners, const std::array<std::int64_t, 3>& base);
  // Whether the whole voxel is surely in the cell.
  bool has_voxel(const std::array<std::int64_t, 3>& at) const;
  std::array<double, 4> weights(const std::array<std::int64_t, 3>& at) const;

 private:
  long double weight(std::size_t k, const std::array<std::int64_t, 3>& at) const;

  std::size_t corners_;
  std::array<std::int64_t, 3> base_;
  std::array<long double, 4> at_base_{};
  std::array<std::array<long double, 3>, 4> step_{};  // from a voxel to the next on each axis
  std::array<long double, 4> half_{};                 // the most by which the weight changes within a voxel
};

// Whether points are in a cell, exactly, and the weights there.
class CellAtPoint {
 public:
  // See sample_shares().
  CellAtPoint(std::span<const Point> corners, std::span<const std::uint8_t> oriented);
  bool has(const Point& place) const;
  std::array<double, 4> weights(const Point& place) const;

 private:
  std::span<const Point> corners_;
  std::array<Point, 4> oriented_;
  Bounds bounds_;
};

// The gradient of the function that is linear in the cell, times d! times the signed volume of the cell: the sum over
// the vertices of (value - first value) times the vertex's gradient, so the volume does not divide. Right to 1e-14 of
// the terms of the sum. REQUIRES: finite values.
std::array<ScaledDouble, 3> gradient_times_volume(std::span<const Point> corners, std::span<const double> values);

}  // namespace tessera::density
