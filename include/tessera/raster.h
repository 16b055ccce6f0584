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

class TESSERA_PUBLIC RasterRequest : public SurfaceRequest<RasterRequest> {
 public:
  // `res`: the width and height of a pixel, in units of the coordinates, above 0.
  explicit RasterRequest(double res);

  // xmin, ymin, xmax, ymax: what the raster covers; default: the bounds of the result.
  RasterRequest& bbox(const std::array<double, 4>& box);
  // A hillshade of the heights, as gdaldem hillshade -compute_edges makes it of the raster, with light from `azimuth`
  // (degrees from north, clockwise), `altitude` degrees above the horizon: whole numbers from 1 to 255.
  RasterRequest& hillshade(double azimuth = 315, double altitude = 45);
  // Pixels of 64 bits; of 32 by default.
  RasterRequest& doubles(bool doubles);
  // 0: all processors.
  RasterRequest& threads(unsigned threads);
};

// Programs have its size compiled in: it stays as it is.
struct Raster {
  std::int64_t width = 0, height = 0;  // in pixels
  double left = 0, top = 0;            // of its corner, in the coordinates of the result
  std::uint64_t pixels = 0;            // with a value
  std::uint64_t left_out = 0;          // cells, for their edges
  std::vector<double> values;          // height x width, from the top; NaN where there is none
};

// Which cell has a pixel, and its value, is a function of the triangulation alone, to the last bit. Failure: usage for
// a 3D result, and when there is no such attribute; corrupt, io, interrupted; memory when it does not fit.
TESSERA_PUBLIC Raster draw_raster(const Triangulation& triangulation, const RasterRequest& request);
// The same pixels as a Cloud Optimized GeoTIFF, whole or not at all; it may be larger than memory. Returns a sentence
// when the coordinates have no system, else "". Failure: also usage when `target` exists or does not end in .tif.
TESSERA_PUBLIC std::string write_raster(const Triangulation& triangulation, const std::filesystem::path& target,
                                        const RasterRequest& request);

}  // namespace tessera
