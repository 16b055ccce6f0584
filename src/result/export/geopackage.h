// A GeoPackage that appears whole or not at all, written by GDAL, row by row.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "src/base/crs/gdal_library.h"
#include "src/base/files/temporary.h"
#include "src/base/result.h"

namespace tessera::exports {

class GeoPackage {
 public:
  struct Field {
    std::string name;
    OGRFieldType type;
    OGRFieldSubType subtype = OFSTNone;
  };
  struct Layer {
    OGRLayerH layer = nullptr;
    OGRFeatureH feature = nullptr;  // filled anew for every row
  };

  // `crs`: as a manifest has it. Errors, here and below: io, with GDAL's reason; bad_input when it does not understand
  // the system.
  static Result<std::unique_ptr<GeoPackage>> create(const std::filesystem::path& path, const std::string& crs);
  ~GeoPackage();
  GeoPackage(const GeoPackage&) = delete;
  GeoPackage& operator=(const GeoPackage&) = delete;

  const GdalLibrary& gdal() const { return gdal_; }
  // Layers come first, then begin(), then rows. A layer is good as long as this object.
  Result<Layer> add_layer(const char* name, OGRwkbGeometryType type, const std::vector<Field>& fields,
                          bool spatial_index);
  Status begin();
  // With the fields of the layer's feature as they are set, and a geometry of `size` bytes.
  Status add(const Layer& to, const void* wkb, std::size_t size);
  // Runs the statement, if there is one, makes the spatial indices, and gives the file its name; the size in bytes.
  Result<std::uint64_t> finish(const char* statement = nullptr);

 private:
  GeoPackage(const GdalLibrary& gdal, SpatialReference reference, const std::filesystem::path& path);
  Error refused(const std::string& what) const;
  void release();
  // GDAL writes, not src/base/files: geometries are drawn from the thread's ledger as they come, the rest at the end.
  Status draw(std::uint64_t bytes);

  const GdalLibrary& gdal_;
  GdalQuiet quiet_;
  SpatialReference reference_;
  std::filesystem::path path_;
  TemporaryFile temporary_;
  GDALDatasetH dataset_ = nullptr;
  std::vector<Layer> layers_;
  std::uint64_t drawn_ = 0;
};

}  // namespace tessera::exports
