// Writes a GeoPackage, or another file of layers, with GDAL, row by row. The file appears only when it is complete.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "src/base/crs/gdal_library.h"
#include "src/base/files/temporary.h"
#include "src/base/result.h"
#include "src/result/store/stamp.h"

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

  enum class Kind : std::uint8_t { geopackage, flatgeobuf };
  // `crs` is a coordinate system as a manifest has it. Each table of a GeoPackage gets the metadata; GDAL cannot write
  // any into a FlatGeobuf. A FlatGeobuf has one layer. Errors, here and below: io, with
  // GDAL's reason; bad_input when GDAL does not know the coordinate system.
  static Result<std::unique_ptr<GeoPackage>> create(const std::filesystem::path& path, const std::string& crs,
                                                    MetadataItems metadata, Kind kind = Kind::geopackage);
  ~GeoPackage();
  GeoPackage(const GeoPackage&) = delete;
  GeoPackage& operator=(const GeoPackage&) = delete;

  const GdalLibrary& gdal() const { return gdal_; }
  // Call add_layer() for all layers first, then begin(), then add() for the rows. A layer is valid as long as this
  // object.
  Result<Layer> add_layer(const char* name, OGRwkbGeometryType type, const std::vector<Field>& fields,
                          bool spatial_index);
  Status begin();
  // Adds a row with the fields that are set in the layer's feature, and a geometry of `size` bytes.
  Status add(const Layer& to, const void* wkb, std::size_t size);
  // Runs the statement, if there is one, makes the spatial indices, and gives the file its final name. Returns its size
  // in bytes.
  Result<std::uint64_t> finish(const char* statement = nullptr);

 private:
  GeoPackage(const GdalLibrary& gdal, SpatialReference reference, const std::filesystem::path& path,
             MetadataItems metadata, Kind kind);
  Error refused(const std::string& what) const;
  void release();
  // GDAL writes the file without src/base/files. So the bytes of geometries are drawn from the thread's ledger as they
  // come, and the rest at the end.
  Status draw(std::uint64_t bytes);

  const GdalLibrary& gdal_;
  GdalQuiet quiet_;
  SpatialReference reference_;
  std::filesystem::path path_;
  TemporaryFile temporary_;
  MetadataItems metadata_;
  Kind kind_;
  GDALDatasetH dataset_ = nullptr;
  std::vector<Layer> layers_;
  std::uint64_t drawn_ = 0;
};

}  // namespace tessera::exports
