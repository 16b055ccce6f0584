// Heights of points above a surface, written into copies of their LAS and LAZ files.
//
// The height of a point is its z minus the height of the surface at its x and y: linear in the triangle of a 2D result
// that contains it. So it is exact up to rounding, and no raster stands between (as filters.hag_delaunay of PDAL).
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>

#include "src/base/result.h"
#include "src/input/las_copy/las_copy.h"
#include "src/result/query/stored_triangulation.h"

namespace tessera {

inline constexpr const char* height_dimension = "HeightAboveGround";

struct HeightsOptions {
  LasPacking packing = LasPacking::as_input;
  bool replace = false;                // a dimension of this name in the input is left out
  std::optional<double> outside = {};  // the height of points outside of the surface's hull; nothing: NaN
  unsigned threads = 1;
  std::stop_token stop = {};
};

struct HeightsCopy {
  std::uint64_t points = 0;
  std::uint64_t outside = 0;  // of them, outside of the surface's hull
};

// Copies the LAS or LAZ file `input` to `to`, with the dimension HeightAboveGround for each point. Nothing else of the
// file changes (las_copy.h). Errors: those of Cloud::open(), copy_las() and StoredTriangulation::interpolate(); usage
// when the result is 3D or a region, has no heights, or has another coordinate system than the file.
Result<HeightsCopy> copy_with_heights(const query::StoredTriangulation& ground, const std::filesystem::path& input,
                                      const std::filesystem::path& to, const HeightsOptions& options);

}  // namespace tessera
