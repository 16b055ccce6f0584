// Densities and fields on a grid of pixels or voxels: from the linear functions of the cells of a result, the exact
// mean over each voxel, or the value at its centre.
//
// The density is that of the Delaunay tessellation field estimator (src/result/measure/star_density.h). The mean over a
// voxel is the sum, over the cells that meet the voxel, of the integral of the linear function over the common part,
// divided by the volume of the voxel (Powell, Abel, Journal of Computational Physics 297 (2015)). So the grid has the
// mass of the points, if it covers all of them. Outside of the hull the density is 0. A field is averaged over the part
// of the voxel that is in the hull, and has no value, NaN, outside. A periodic cloud has no hull along its periodic
// axes: there the grid covers the period, and what of a cell is beyond the border counts on the other side.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/result/density/quantity.h"
#include "src/result/density/voxel_grid.h"

namespace tessera::density {

struct GridOptions {
  GridShape shape = {};
  GridKind kind = GridKind::density;
  std::vector<std::string> names = {};  // the attributes of a field, or of a vector's components
  std::string mass = {};                // of a density: the attribute that has the masses; empty: each point has mass 1
  bool sample = false;                  // the values at the centres, not the means
  bool overwrite = false;
  std::uint64_t memory_bytes = std::uint64_t{1} << 30;  // at least the memory of one tile is used
  unsigned threads = 1;
  std::function<void(double)> progress = {};  // gets the fraction done, 0..1, from one thread at a time; may be null
};

// Where the values are, and what they add up to.
struct GridFacts {
  int dimension = 3;
  std::array<std::int64_t, 3> size{1, 1, 1};  // in voxels, along x, y and z
  std::array<double, 3> origin{};             // the least corner of the grid
  std::array<double, 3> widths{};             // of a voxel
  std::optional<double> res = {};             // the same, if it is the same along all axes
  std::array<double, 3> period{};             // of the result, 0 along an axis without a period
  std::size_t components = 1;
  std::uint64_t known = 0;  // voxels with a value
  // Of a density: the sum of the masses of all vertices, and of all voxels.
  std::optional<double> mass = {}, grid_mass = {};
  std::string note = {};  // what there is to say of the values; else empty
};

struct GridFile {
  std::filesystem::path path;
  GridFacts facts;
  std::uint64_t bytes = 0;  // of the file
};

// One line of JSON, without its end, for the command's output.
std::string to_json(const GridFile& file);

// Error usage when the name is not one of a GeoTIFF (.tif), a NumPy array (.npy), HDF5 (.h5, .hdf5) or FITS (.fits),
// and for an existing file, unless `overwrite` is set.
Status check_grid_target(const std::filesystem::path& target, bool overwrite);

// Writes `target`. A .tif is a Cloud Optimized GeoTIFF with 64 bits a pixel, for 2D results; its lines begin at the
// top. A .npy is a NumPy array of 64-bit floats with the indices [y][x] or [z][y][x], all ascending, and one more index
// for the components of a vector. array_files.h describes a .h5 and a .fits. The values depend only on the
// triangulation: every value is the same to the last bit however the result is tiled, and in grids of different boxes.
// All tiles are read, those of points-only results rebuilt (twice for a density). Sums are kept in a scratch file
// beside the target, with 48 bytes for each voxel that a cell meets (and as much again for each component and for the
// volume of a field). The file is written whole or not at all. Errors: usage, before anything is written; bad_input for
// a mass that is not finite; corrupt for a damaged tile; memory; io; interrupted.
Result<GridFile> write_grid(const std::filesystem::path& out, const std::filesystem::path& target,
                            const GridOptions& options, std::stop_token stop);

// Returns the grid, of which only the manifest is read. Errors: usage; those of opening a result.
Result<VoxelGrid> grid_of(const std::filesystem::path& out, const GridOptions& options);

struct GridArray {
  GridFacts facts;
  std::vector<double> values;  // as in a .npy file
};

// Returns the same values. Ignores options.overwrite. `scratch` is the folder for the sums. Error memory for more than
// `values_max` values.
Result<GridArray> draw_grid(const std::filesystem::path& out, const std::filesystem::path& scratch,
                            const GridOptions& options, std::uint64_t values_max, std::stop_token stop);

}  // namespace tessera::density
