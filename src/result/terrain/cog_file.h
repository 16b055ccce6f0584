// A Cloud Optimized GeoTIFF, made by GDAL. Pixels come in any order and are kept in a file beside it until there are
// all; so the raster may be larger than memory.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "src/base/crs/gdal_cache.h"
#include "src/base/crs/gdal_library.h"
#include "src/base/files/temporary.h"
#include "src/base/result.h"
#include "src/result/terrain/blocks.h"
#include "src/result/terrain/dem.h"
#include "src/result/terrain/grid.h"

namespace tessera::terrain {

struct CogOptions {
  std::string crs;                  // as a manifest has it
  std::string name;                 // of the band
  bool doubles = false;             // pixels of 64 bits, not 32
  bool heights = true;              // else what the system says of heights does not hold
  std::optional<Light> light = {};  // the file is not the pixels that are added, but their hillshade, 1..255; 0: none
  std::uint64_t cache_bytes = std::uint64_t{64} << 20;  // of GDAL
  unsigned threads = 1;
};

class CogFile {
 public:
  // Errors, here and below: io, with GDAL's reason; bad_input when it does not understand the system.
  static Result<std::unique_ptr<CogFile>> create(const std::filesystem::path& target, const Grid& grid,
                                                 const CogOptions& options);
  ~CogFile();
  CogFile(const CogFile&) = delete;
  CogFile& operator=(const CogFile&) = delete;

  // Takes the pixels drawn. Safe to call from several threads. Error corrupt when a pixel has come before.
  Status add(Blocks& blocks);
  std::uint64_t pixels() const { return pixels_; }  // with a value, so far

  // Compresses, makes the overviews, and gives the file its name. Told the part that is done, `go_on` says whether to
  // go on; error interrupted when not. The size in bytes.
  Result<std::uint64_t> finish(const std::function<bool(double)>& go_on);

 private:
  CogFile(const GdalLibrary& gdal, const std::filesystem::path& target, const Grid& grid, const CogOptions& options);
  Status create_raw();
  Status add_block(std::int64_t x, std::int64_t y, Block& block);
  // In the place of the pixels there is their hillshade then.
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
