// Writes a FlatGeobuf file with GDAL, feature by feature. The file appears only when it is complete. GDAL keeps the
// features in a file beside it, and 40 bytes of each in memory, until it has sorted them for the spatial index.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "src/base/crs/gdal_library.h"
#include "src/base/files/temporary.h"
#include "src/base/result.h"
#include "src/result/export/geopackage.h"

namespace tessera::voronoi {

// Used like a GeoPackage, with one layer.
class FlatGeobuf {
 public:
  static Result<std::unique_ptr<FlatGeobuf>> create(const std::filesystem::path& path, const std::string& crs);
  ~FlatGeobuf();
  FlatGeobuf(const FlatGeobuf&) = delete;
  FlatGeobuf& operator=(const FlatGeobuf&) = delete;

  const GdalLibrary& gdal() const { return gdal_; }
  Result<exports::GeoPackage::Layer> add_layer(const char* name, OGRwkbGeometryType type,
                                               const std::vector<exports::GeoPackage::Field>& fields,
                                               bool spatial_index);
  static Status begin() { return success(); }
  Status add(const exports::GeoPackage::Layer& to, const void* wkb, std::size_t size);
  Result<std::uint64_t> finish();

 private:
  FlatGeobuf(const GdalLibrary& gdal, SpatialReference reference, const std::filesystem::path& path);
  Error refused(const std::string& what) const;
  void release();

  const GdalLibrary& gdal_;
  GdalQuiet quiet_;
  SpatialReference reference_;
  std::filesystem::path path_;
  TemporaryFile temporary_;
  GDALDatasetH dataset_ = nullptr;
  OGRFeatureH feature_ = nullptr;
  std::uint64_t drawn_ = 0;
};

}  // namespace tessera::voronoi
