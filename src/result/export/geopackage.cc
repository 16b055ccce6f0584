#include "src/result/export/geopackage.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include "src/base/files/names.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/base/ledger.h"

namespace tessera::exports {

namespace fs = std::filesystem;

namespace {

// The file has another name until it is complete, so it needs no journal and no sync at every step.
constexpr const char* options[] = {"OGR_SQLITE_SYNCHRONOUS", "OGR_SQLITE_JOURNAL"};

// GDAL needs the ending.
fs::path name_until_whole(const fs::path& path, GeoPackage::Kind kind) {
  return temporary_name(path).string() + (kind == GeoPackage::Kind::geopackage ? ".gpkg" : ".fgb");
}

}  // namespace

GeoPackage::GeoPackage(const GdalLibrary& gdal, SpatialReference reference, const fs::path& path,
                       MetadataItems metadata, Kind kind)
    : gdal_(gdal),
      quiet_(gdal),
      reference_(std::move(reference)),
      path_(path),
      temporary_(name_until_whole(path, kind)),
      metadata_(std::move(metadata)),
      kind_(kind) {}

GeoPackage::~GeoPackage() {
  release();
  for (const char* option : options) gdal_.CPLSetThreadLocalConfigOption(option, nullptr);
  for (const char* side : {"-journal", "-wal", "-shm"}) {
    std::error_code code;
    fs::remove(temporary_.path().string() + side, code);
  }
}

Error GeoPackage::refused(const std::string& what) const {
  return error(Errc::io, path_.string() + ": " + what + ": " + quiet_.message());
}

Result<std::unique_ptr<GeoPackage>> GeoPackage::create(const fs::path& path, const std::string& crs,
                                                       MetadataItems metadata, Kind kind) {
  BOOST_OUTCOME_TRY(gdal, gdal_library());
  BOOST_OUTCOME_TRY(reference, SpatialReference::parse(*gdal, crs));
  auto file = std::unique_ptr<GeoPackage>(new GeoPackage(*gdal, std::move(reference), path, std::move(metadata), kind));
  std::error_code code;
  fs::remove(file->temporary_.path(), code);
  for (const char* option : options) gdal->CPLSetThreadLocalConfigOption(option, "OFF");
  const bool is_package = kind == Kind::geopackage;
  const GDALDriverH driver = gdal->GDALGetDriverByName(is_package ? "GPKG" : "FlatGeobuf");
  if (driver == nullptr)
    return error(Errc::io, std::string("this GDAL cannot write ") + (is_package ? "GeoPackage" : "FlatGeobuf"));
  file->dataset_ = gdal->GDALCreate(driver, file->temporary_.path().c_str(), 0, 0, 0, GDT_Unknown, nullptr);
  if (file->dataset_ == nullptr) return file->refused("cannot create");
  return file;
}

Result<GeoPackage::Layer> GeoPackage::add_layer(const char* name, OGRwkbGeometryType type,
                                                const std::vector<Field>& fields, bool spatial_index) {
  char choice[] = "SPATIAL_INDEX=NO";
  char* choices[] = {choice, nullptr};
  Layer to;
  to.layer = gdal_.GDALDatasetCreateLayer(dataset_, name, reference_.get(), type, spatial_index ? nullptr : choices);
  if (to.layer == nullptr) return refused("cannot create its table");
  for (const auto& [title, kind, subtype] : fields) {
    const OGRFieldDefnH field = gdal_.OGR_Fld_Create(title.c_str(), kind);
    gdal_.OGR_Fld_SetSubType(field, subtype);
    const bool added = gdal_.OGR_L_CreateField(to.layer, field, 0) == OGRERR_NONE;
    gdal_.OGR_Fld_Destroy(field);
    if (!added) return refused("cannot create its table");
  }
  if (kind_ == Kind::geopackage) {
    for (const auto& [item, value] : metadata_)
      if (gdal_.GDALSetMetadataItem(to.layer, item.c_str(), value.c_str(), nullptr) != CE_None)
        return refused("cannot write the metadata of its table");
  }
  // Makes the table now and not with its first row, so that layers are in their order.
  if (gdal_.OGR_L_SyncToDisk(to.layer) != OGRERR_NONE) return refused("cannot create its table");
  to.feature = gdal_.OGR_F_Create(gdal_.OGR_L_GetLayerDefn(to.layer));
  layers_.push_back(to);
  return to;
}

Status GeoPackage::draw(std::uint64_t bytes) {
  drawn_ += bytes;
  return Ledger::draw_write(bytes);
}

Status GeoPackage::begin() {
  if (kind_ == Kind::flatgeobuf) return success();  // which has no transactions
  if (gdal_.GDALDatasetStartTransaction(dataset_, 0) != OGRERR_NONE) return refused("cannot write");
  return success();
}

Status GeoPackage::add(const Layer& to, const void* wkb, std::size_t size) {
  BOOST_OUTCOME_TRYV(draw(size));
  OGRGeometryH geometry = nullptr;
  if (gdal_.OGR_G_CreateFromWkb(wkb, nullptr, &geometry, static_cast<int>(size)) != OGRERR_NONE)
    return refused("cannot make a geometry");
  gdal_.OGR_F_SetFID(to.feature, OGRNullFID);
  if (gdal_.OGR_F_SetGeometryDirectly(to.feature, geometry) != OGRERR_NONE ||
      gdal_.OGR_L_CreateFeature(to.layer, to.feature) != OGRERR_NONE)
    return refused("cannot write");
  return success();
}

Result<std::uint64_t> GeoPackage::finish(const char* statement) {
  if (kind_ == Kind::geopackage && gdal_.GDALDatasetCommitTransaction(dataset_) != OGRERR_NONE)
    return refused("cannot write");
  gdal_.CPLErrorReset();
  if (statement != nullptr)
    gdal_.GDALDatasetReleaseResultSet(dataset_, gdal_.GDALDatasetExecuteSQL(dataset_, statement, nullptr, nullptr));
  release();  // makes the spatial indices; only the message reports their errors
  if (*gdal_.CPLGetLastErrorMsg() != '\0') return refused("cannot write");
  BOOST_OUTCOME_TRY(bytes, file_bytes(temporary_.path()));
  BOOST_OUTCOME_TRYV(draw(bytes - std::min<std::uint64_t>(bytes, drawn_)));
  BOOST_OUTCOME_TRYV(publish(temporary_.path(), path_));
  temporary_.keep();
  BOOST_OUTCOME_TRYV(sync_folder(path_.parent_path()));
  return bytes;
}

void GeoPackage::release() {
  for (const Layer& layer : layers_)
    if (layer.feature != nullptr) gdal_.OGR_F_Destroy(layer.feature);
  layers_.clear();
  if (dataset_ != nullptr) gdal_.GDALClose(dataset_);
  dataset_ = nullptr;
}

}  // namespace tessera::exports
