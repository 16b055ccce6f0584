// GDAL's cache of pixels.
#pragma once

#include <cstdint>

#include "src/base/crs/gdal_library.h"

namespace tessera {

// While it lives, GDAL's cache may hold these bytes more. GDAL has one cache for all that the process does with it, and
// one bound: here all that work with it at once add up theirs, and who is last puts back what was there before.
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
