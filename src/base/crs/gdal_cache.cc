#include "src/base/crs/gdal_cache.h"

#include <mutex>

namespace tessera {
namespace {

struct Shares {
  std::mutex mutex;
  std::uint64_t count = 0, bytes = 0;
  GIntBig before = 0;
};

Shares& shares() {
  static Shares all;
  return all;
}

}  // namespace

GdalCacheShare::GdalCacheShare(const GdalLibrary& gdal, std::uint64_t bytes) : gdal_(gdal), bytes_(bytes) {
  Shares& all = shares();
  const std::lock_guard lock(all.mutex);
  if (all.count++ == 0) all.before = gdal_.GDALGetCacheMax64();
  all.bytes += bytes_;
  gdal_.GDALSetCacheMax64(static_cast<GIntBig>(all.bytes));
}

GdalCacheShare::~GdalCacheShare() {
  Shares& all = shares();
  const std::lock_guard lock(all.mutex);
  all.bytes -= bytes_;
  gdal_.GDALSetCacheMax64(--all.count == 0 ? all.before : static_cast<GIntBig>(all.bytes));
}

}  // namespace tessera
