#include "src/result/voronoi/flatgeobuf.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include "src/base/files/names.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/base/ledger.h"

namespace tessera::voronoi {

namespace fs = std::filesystem;

// GDAL needs the ending.
FlatGeobuf::FlatGeobuf(const GdalLibrary& gdal, SpatialReference reference, const fs::path& path)
    : gdal_(gdal),
      quiet_(gdal),
      reference_(std::move(reference)),
      path_(path),
      temporary_(temporary_name(path).string() + ".fgb") {}

FlatGeobuf::~FlatGeobuf() {
  release();
  std::error_code code;
  fs::remove(fs::path(temporary_.path()).replace_extension().string() + "_temp.fgb", code);
}

Error FlatGeobuf::refused(const std::string& what) const {
  return error(Errc::io, path_.string() + ": " + what + ": " + quiet_.message());
}

Result<std::unique_ptr<FlatGeobuf>> FlatGeobuf::create(const fs::path& path, const std::string& crs) {
  BOOST_OUTCOME_TRY(gdal, gdal_library());
  BOOST_OUTCOME_TRY(reference, SpatialReference::parse(*gdal, crs));
  auto file = std::unique_ptr<FlatGeobuf>(new FlatGeobuf(*gdal, std::move(reference), path));
  std::error_code code;
  fs::remove(file->temporary_.path(), code);
  const GDALDriverH driver = gdal->GDALGetDriverByName("FlatGeobuf");
  if (driver == nullptr) return error(Errc::io, "this GDAL cannot write FlatGeobuf");
  file->dataset_ = gdal->GDALCreate(driver, file->temporary_.path().c_str(), 0, 0, 0, GDT_Unknown, nullptr);
  if (file->dataset_ == nullptr) return file->refused("cannot create");
  return file;
}

Result<exports::GeoPackage::Layer> FlatGeobuf::add_layer(const char* name, OGRwkbGeometryType type,
                                                         const std::vector<exports::GeoPackage::Field>& fields,
                                                         bool spatial_index) {
  char choice[] = "SPATIAL_INDEX=NO";
  char* choices[] = {choice, nullptr};
  exports::GeoPackage::Layer to;
  to.layer = gdal_.GDALDatasetCreateLayer(dataset_, name, reference_.get(), type, spatial_index ? nullptr : choices);
  if (to.layer == nullptr) return refused("cannot create its layer");
  for (const auto& [title, kind, subtype] : fields) {
    const OGRFieldDefnH field = gdal_.OGR_Fld_Create(title.c_str(), kind);
    gdal_.OGR_Fld_SetSubType(field, subtype);
    const bool added = gdal_.OGR_L_CreateField(to.layer, field, 0) == OGRERR_NONE;
    gdal_.OGR_Fld_Destroy(field);
    if (!added) return refused("cannot create its layer");
  }
  to.feature = feature_ = gdal_.OGR_F_Create(gdal_.OGR_L_GetLayerDefn(to.layer));
  return to;
}

Status FlatGeobuf::add(const exports::GeoPackage::Layer& to, const void* wkb, std::size_t size) {
  drawn_ += size;
  BOOST_OUTCOME_TRYV(Ledger::draw_write(size));
  OGRGeometryH geometry = nullptr;
  if (gdal_.OGR_G_CreateFromWkb(wkb, nullptr, &geometry, static_cast<int>(size)) != OGRERR_NONE)
    return refused("cannot make a geometry");
  gdal_.OGR_F_SetFID(to.feature, OGRNullFID);
  if (gdal_.OGR_F_SetGeometryDirectly(to.feature, geometry) != OGRERR_NONE ||
      gdal_.OGR_L_CreateFeature(to.layer, to.feature) != OGRERR_NONE)
    return refused("cannot write");
  return success();
}

Result<std::uint64_t> FlatGeobuf::finish() {
  gdal_.CPLErrorReset();
  release();  // sorts the features; only the message reports errors
  if (*gdal_.CPLGetLastErrorMsg() != '\0') return refused("cannot write");
  BOOST_OUTCOME_TRY(bytes, file_bytes(temporary_.path()));
  BOOST_OUTCOME_TRYV(Ledger::draw_write(bytes - std::min<std::uint64_t>(bytes, drawn_)));
  BOOST_OUTCOME_TRYV(publish(temporary_.path(), path_));
  temporary_.keep();
  BOOST_OUTCOME_TRYV(sync_folder(path_.parent_path()));
  return bytes;
}

void FlatGeobuf::release() {
  if (feature_ != nullptr) gdal_.OGR_F_Destroy(feature_);
  feature_ = nullptr;
  if (dataset_ != nullptr) gdal_.GDALClose(dataset_);
  dataset_ = nullptr;
}

}  // namespace tessera::voronoi
