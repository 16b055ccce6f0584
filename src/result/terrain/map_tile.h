// Draws tiles of web maps (OGC's WebMercatorQuad) from a raster of heights that write_dem() has made.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "src/base/crs/gdal_library.h"
#include "src/base/point.h"
#include "src/base/result.h"

namespace tessera::terrain {

// The whole map is one tile at level 0, and each tile is divided into four at the next level. Rows count from the top.
struct MapTile {
  static constexpr int levels = 25;
  int level = 0;
  std::int64_t row = 0, column = 0;
  bool exists() const;
  // In metres of web mercator.
  Bounds bounds() const;
};

// Pixels without a height are transparent.
enum class MapStyle : std::uint8_t {
  hillshade,    // by light from the north-west, in grey
  terrain_rgb,  // -10000 + (red * 65536 + green * 256 + blue) / 10 metres
};

class HeightRaster {
 public:
  // Error usage when the file is no such raster or has no coordinate system; io without GDAL.
  static Result<std::unique_ptr<HeightRaster>> open(const std::filesystem::path& path);
  ~HeightRaster();
  HeightRaster(const HeightRaster&) = delete;
  HeightRaster& operator=(const HeightRaster&) = delete;

  // West, south, east, north.
  const std::array<double, 4>& extent() const { return extent_; }
  // A PNG of 256 x 256 pixels. REQUIRES: the tile exists.
  Result<std::string> draw(const MapTile& tile, MapStyle style) const;

 private:
  HeightRaster(const GdalLibrary& gdal, GDALDatasetH dataset) : gdal_(gdal), dataset_(dataset) {}
  Result<GDALDatasetH> warped(const Bounds& bounds, int pixels) const;
  Result<std::string> png(const std::vector<std::vector<unsigned char>>& bands) const;
  Error refused(const GdalQuiet& quiet) const;

  const GdalLibrary& gdal_;
  GDALDatasetH dataset_;
  std::string path_, system_;  // as WKT
  Bounds box_;                 // in metres of web mercator
  std::array<double, 4> extent_{};
};

}  // namespace tessera::terrain
