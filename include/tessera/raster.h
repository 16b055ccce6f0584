// The surface of a 2D result as a raster (docs/terrain.md).
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "tessera/failure.h"
#include "tessera/surface_request.h"
#include "tessera/triangulation.h"
#include "tessera/visibility.h"

namespace tessera {

class RasterRequest;
extern template class TESSERA_PUBLIC SurfaceRequest<RasterRequest>;

// How the value of a pixel follows from the vertices.
enum class RasterMethod {
  linear,   // linear in the cell that has the pixel
  natural,  // Sibson's natural neighbours
  laplace,  // natural neighbours, with the weights of Belikov and Sugihara
};

// Options of draw_raster() and write_raster(). Every function returns *this.
class TESSERA_PUBLIC RasterRequest : public SurfaceRequest<RasterRequest> {
 public:
  // `res`: the width and height of a pixel, in units of the coordinates, above 0.
  explicit RasterRequest(double res);

  // The box that the raster covers: xmin, ymin, xmax, ymax. Default: the bounds of the result.
  RasterRequest& bbox(const std::array<double, 4>& box);
  // Default: linear.
  RasterRequest& method(RasterMethod method);
  // Draws a hillshade of the heights instead: the one that gdaldem hillshade -compute_edges makes of the raster. Light
  // comes from `azimuth`, in degrees clockwise from north, and `altitude`, in degrees above the horizon (above 0, at
  // most 90). Pixels are whole numbers from 1 to 255.
  RasterRequest& hillshade(double azimuth = 315, double altitude = 45);
  // Pixels have 64 bits; by default 32.
  RasterRequest& doubles(bool doubles);
  // 0, the default: all processors.
  RasterRequest& threads(unsigned threads);
};

// A raster in memory. Programs are compiled with the size of this struct, so it never changes.
struct Raster {
  std::int64_t width = 0, height = 0;  // in pixels
  double left = 0, top = 0;            // the upper left corner, in the coordinates of the result
  std::uint64_t pixels = 0;            // the number of pixels with a value
  std::uint64_t left_out = 0;          // the number of cells that max_edge() left out
  std::vector<double> values;          // height x width, from the top row down; NaN for pixels without a value
};

// Returns the raster. The cell of a pixel and its value depend on the triangulation alone, to the last bit. Without
// doubles() values are rounded to 32 bits. Failure: usage for a 3D result and for an attribute that the result does not
// have; memory when the raster does not fit; corrupt, io, interrupted.
TESSERA_PUBLIC Raster draw_raster(const Triangulation& triangulation, const RasterRequest& request);
// Writes the same pixels as a Cloud Optimized GeoTIFF, which may be larger than memory. The file is written whole or
// not at all. Returns a sentence if the coordinates have no coordinate system, else "". Failure: also usage if `target`
// exists or does not end in .tif.
TESSERA_PUBLIC std::string write_raster(const Triangulation& triangulation, const std::filesystem::path& target,
                                        const RasterRequest& request);

}  // namespace tessera
