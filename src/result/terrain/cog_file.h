// Writes a Cloud Optimized GeoTIFF with GDAL. Pixels come in any order, and are kept in a file beside it until all have
// come. So the raster may be larger than memory.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "src/base/crs/gdal_cache.h"
#include "src/base/crs/gdal_library.h"
#include "src/base/files/temporary.h"
#include "src/base/result.h"
#include "src/result/store/stamp.h"
#include "src/result/terrain/blocks.h"
#include "src/result/terrain/dem.h"
#include "src/result/terrain/grid.h"

namespace tessera::terrain {

struct CogOptions {
  std::string crs;                  // as a manifest has it
  std::string name;                 // of the band
  bool doubles = false;             // pixels have 64 bits, not 32
  bool heights = true;              // else the vertical part of the coordinate system does not apply
  std::optional<Light> light = {};  // if set, the file has the hillshade of the pixels, 1..255; 0: none
  std::uint64_t cache_bytes = std::uint64_t{64} << 20;  // of GDAL
  unsigned threads = 1;
  MetadataItems metadata = {};
};

class CogFile {
 public:
  // Errors, here and below: io, with GDAL's reason; bad_input when GDAL does not know the coordinate system.
  static Result<std::unique_ptr<CogFile>> create(const std::filesystem::path& target, const Grid& grid,
                                                 const CogOptions& options);
  ~CogFile();
  CogFile(const CogFile&) = delete;
  CogFile& operator=(const CogFile&) = delete;

  // Takes the drawn pixels. Safe to call from several threads. Error corrupt when a pixel has come before.
  Status add(Blocks& blocks);
  // For a result whose digest is known only when all its tiles have come.
  void set_metadata(MetadataItems metadata) { options_.metadata = std::move(metadata); }
  std::uint64_t pixels() const { return pixels_; }  // with a value, so far

  // Compresses, makes the overviews, and gives the file its name. Calls `go_on` with the fraction that is done; when it
  // returns false, ends with error interrupted. Returns the size in bytes.
  Result<std::uint64_t> finish(const std::function<bool(double)>& go_on);

 private:
  CogFile(const GdalLibrary& gdal, const std::filesystem::path& target, const Grid& grid, const CogOptions& options);
  Status create_raw();
  Status add_block(std::int64_t x, std::int64_t y, Block& block);
  // Replaces the pixels by their hillshade.
  Status shade(const std::function<bool(double)>& go_on);
  Error refused(const GdalQuiet& quiet) const;

  const GdalLibrary& gdal_;
  std::filesystem::path target_;
  Grid grid_;
  CogOptions options_;
  TemporaryFile raw_, shade_, cog_;
  GdalCacheShare cache_;
  std::mutex mutex_;
  GDALDatasetH dataset_ = nullptr;
  std::vector<bool> written_;  // by block
  std::vector<double> old_;    // a block
  std::uint64_t pixels_ = 0;
};

}  // namespace tessera::terrain
