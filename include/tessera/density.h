// Densities and fields of a result on a grid of pixels or voxels (docs/density.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "tessera/failure.h"
#include "tessera/triangulation.h"
#include "tessera/visibility.h"

namespace tessera {

// Options of draw_density(), density_widths() and write_density(). Without field(), divergence(), curl() or shear() the
// grid has the density of the points. Every function returns *this.
class TESSERA_PUBLIC DensityRequest {
 public:
  // `res`: the width of a pixel or voxel, in units of the coordinates, above 0. Along a periodic axis the period must
  // be a multiple of it.
  explicit DensityRequest(double res);
  // The number of pixels or voxels along each axis, 1 to 2^24, or one number for all axes. They fill the period; along
  // axes without one the box.
  explicit DensityRequest(std::span<const std::int64_t> voxels);
  DensityRequest(const DensityRequest&);
  DensityRequest& operator=(const DensityRequest&);
  ~DensityRequest();

  // The box that the grid covers: 4 numbers in 2D, xmin, ymin, xmax, ymax; 6 in 3D. Default: the bounds of the result,
  // and along a periodic axis the period. Failure: usage for another number of numbers.
  DensityRequest& bbox(std::span<const double> box);
  // The attribute of the vertices that has their masses. Default: each point has the mass 1.
  DensityRequest& mass(const std::string& name);
  // The mean of an attribute of the vertices.
  DensityRequest& field(const std::string& name);
  // The mean divergence, or curl, of the vector with these attributes as components. The curl is a number in 2D, and a
  // vector in 3D.
  DensityRequest& divergence(const std::vector<std::string>& names);
  DensityRequest& curl(const std::vector<std::string>& names);
  // The mean shear of such a vector, which is the symmetric part of its gradient without the trace: the components xx
  // and xy in 2D, and xx, xy, xz, yy and yz in 3D.
  DensityRequest& shear(const std::vector<std::string>& names);
  // The values at the centres of pixels or voxels, not the means over them.
  DensityRequest& sample(bool sample);
  // Replaces an existing file of the same name.
  DensityRequest& overwrite(bool overwrite);
  // The memory for tiles and sums; 0, the default: 70 % of the free memory.
  DensityRequest& memory_bytes(std::uint64_t bytes);
  // 0, the default: all processors.
  DensityRequest& threads(unsigned threads);
  DensityRequest& stop(std::stop_token stop);

 private:
  friend struct OptionsInside;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// A grid in memory. Programs are compiled with the size of this struct, so it never changes.
struct DensityGrid {
  std::vector<std::int64_t> size;  // in pixels or voxels, along x, y and z
  std::vector<double> origin;      // the least corner, in the coordinates of the result
  std::size_t components = 1;      // of a vector or tensor: 3 for the curl in 3D, 2 or 5 for the shear
  std::uint64_t known = 0;         // pixels or voxels with a value
  double mass = 0, grid_mass = 0;  // of a density: of all vertices, and of the grid
  std::string note;                // a sentence about the values, or ""
  // In the order [z][y][x][component], all ascending. NaN where a field has no value; the density is 0 outside of the
  // hull.
  std::vector<double> values;
};

// Returns the grid. Values depend on the triangulation alone, to the last bit. Failure: usage for wrong options and
// attributes that the result does not have; bad_input for a mass that is not finite; memory when the grid does not fit;
// corrupt, io, interrupted.
TESSERA_PUBLIC DensityGrid draw_density(const Triangulation& triangulation, const DensityRequest& request);
// Returns the widths of the pixels or voxels of that grid, along x, y and z. Failure: as draw_density().
TESSERA_PUBLIC std::vector<double> density_widths(const Triangulation& triangulation, const DensityRequest& request);
// Writes the same values to a .npy, .h5 or .fits, or for a 2D result to a .tif, which may be larger than memory. The
// file is written whole or not at all. Returns a sentence about the values, or "". Failure: also usage if `target`
// exists or has another ending.
TESSERA_PUBLIC std::string write_density(const Triangulation& triangulation, const std::filesystem::path& target,
                                         const DensityRequest& request);

}  // namespace tessera
