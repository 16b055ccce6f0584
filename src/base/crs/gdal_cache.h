// Shares of GDAL's cache of pixels.
#pragma once

#include <cstdint>

#include "src/base/crs/gdal_library.h"

namespace tessera {

// A share of GDAL's cache. GDAL has one cache and one bound for the whole process. While there are shares the bound is
// the sum of all shares, and the last share restores the bound from before. Thread-safe.
class GdalCacheShare {
 public:
  GdalCacheShare(const GdalLibrary& gdal, std::uint64_t bytes);
  ~GdalCacheShare();
  GdalCacheShare(const GdalCacheShare&) = delete;
  GdalCacheShare& operator=(const GdalCacheShare&) = delete;

 private:
  const GdalLibrary& gdal_;
  std::uint64_t bytes_;
};

}  // namespace tessera
