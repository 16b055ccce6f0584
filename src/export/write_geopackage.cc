// GeoPackage: one polygon a triangle in the table "triangulation", with a spatial index, written by GDAL.
#include <array>
#include <cstring>

#include "src/crs/gdal_library.h"
#include "src/export/formats.h"
#include "src/files/names.h"
#include "src/files/temporary.h"
#include "src/files/whole_file.h"

namespace tessera::exports {

namespace fs = std::filesystem;

namespace {

// The file has another name until it is whole, so it needs neither a journal nor to be synced at every step.
constexpr const char* options[] = {"OGR_SQLITE_SYNCHRONOUS", "OGR_SQLITE_JOURNAL"};
constexpr const char* fields[] = {"tile", "v0", "v1", "v2"};

// A ring of four corners as GDAL takes it: little endian, the numbers of ISO.
class WkbTriangle {
 public:
  explicit WkbTriangle(bool heights) : axes_(heights ? 3 : 2) {
    bytes_[0] = 1;
    const std::uint32_t head[] = {heights ? 1003U : 3U, 1, 4};
    std::memcpy(bytes_.data() + 1, head, sizeof head);
  }
  const void* make(const CellView& cell) {
    std::byte* to = reinterpret_cast<std::byte*>(bytes_.data()) + 13;
    for (std::size_t k = 0; k < 4; ++k) {
      std::memcpy(to, &cell.at[k % 3], axes_ * sizeof(double));
      to += axes_ * sizeof(double);
    }
    return bytes_.data();
  }
  int size() const { return 13 + static_cast<int>(4 * axes_ * sizeof(double)); }

 private:
  std::size_t axes_;
  std::array<unsigned char, 13 + 96> bytes_{};
};

class GeoPackageWriter : public MeshWriter {
 public:
  static OpenedWriter open(const fs::path& path, const MeshHead& head) {
    BOOST_OUTCOME_TRY(gdal, gdal_library());
    BOOST_OUTCOME_TRY(reference, SpatialReference::parse(*gdal, head.crs));
    auto writer = std::unique_ptr<GeoPackageWriter>(new GeoPackageWriter(*gdal, path, head.heights));
    BOOST_OUTCOME_TRYV(writer->create(reference.get(), head.spatial_index));
    return std::unique_ptr<MeshWriter>(std::move(writer));
  }
  ~GeoPackageWriter() override {
    release();
    for (const char* option : options) gdal_.CPLSetThreadLocalConfigOption(option, nullptr);
    for (const char* side : {"-journal", "-wal", "-shm"}) {
      std::error_code code;
      fs::remove(temporary_.path().string() + side, code);
    }
  }

  void vertex(const VertexView&) override {}
  void cell(const CellView& cell) override {
    if (!status_) return;
    OGRGeometryH polygon = nullptr;
    if (gdal_.OGR_G_CreateFromWkb(triangle_.make(cell), nullptr, &polygon, triangle_.size()) != OGRERR_NONE) {
      status_ = refused("cannot make a polygon");
      return;
    }
    gdal_.OGR_F_SetFID(feature_, OGRNullFID);
    gdal_.OGR_F_SetFieldInteger64(feature_, 0, cell.tile.value);
    for (int k = 0; k < 3; ++k)
      gdal_.OGR_F_SetFieldInteger64(feature_, k + 1, static_cast<GIntBig>(cell.ids[static_cast<std::size_t>(k)].value));
    if (gdal_.OGR_F_SetGeometryDirectly(feature_, polygon) != OGRERR_NONE ||
        gdal_.OGR_L_CreateFeature(layer_, feature_) != OGRERR_NONE)
      status_ = refused("cannot write");
  }
  Status check() override { return status_; }

  Result<std::uint64_t> finish() override {
    BOOST_OUTCOME_TRYV(status_);
    if (gdal_.GDALDatasetCommitTransaction(dataset_) != OGRERR_NONE) return refused("cannot write");
    gdal_.CPLErrorReset();
    release();  // makes the spatial index; its errors are told by the message alone
    if (*gdal_.CPLGetLastErrorMsg() != '\0') return refused("cannot write");
    std::error_code code;
    const auto bytes = fs::file_size(temporary_.path(), code);
    if (code) return error(Errc::io, path_.string() + ": cannot write: " + code.message());
    BOOST_OUTCOME_TRYV(publish(temporary_.path(), path_));
    temporary_.keep();
    BOOST_OUTCOME_TRYV(sync_folder(path_.parent_path()));
    return bytes;
  }

 private:
  GeoPackageWriter(const GdalLibrary& gdal, const fs::path& path, bool heights)
      : gdal_(gdal),
        quiet_(gdal),
        path_(path),
        temporary_(temporary_name(path)),
        triangle_(heights),
        heights_(heights) {}

  // GDAL wants the ending.
  static fs::path temporary_name(const fs::path& path) { return tessera::temporary_name(path).string() + ".gpkg"; }

  Error refused(const std::string& what) const {
    return error(Errc::io, path_.string() + ": " + what + ": " + quiet_.message());
  }

  Status create(OGRSpatialReferenceH reference, bool spatial_index) {
    gdal_.GDALAllRegister();
    std::error_code code;
    fs::remove(temporary_.path(), code);
    for (const char* option : options) gdal_.CPLSetThreadLocalConfigOption(option, "OFF");
    const GDALDriverH driver = gdal_.GDALGetDriverByName("GPKG");
    if (driver == nullptr) return error(Errc::io, "this GDAL cannot write GeoPackage");
    dataset_ = gdal_.GDALCreate(driver, temporary_.path().c_str(), 0, 0, 0, GDT_Unknown, nullptr);
    if (dataset_ == nullptr) return refused("cannot create");
    char choice[] = "SPATIAL_INDEX=NO";
    char* choices[] = {choice, nullptr};
    layer_ = gdal_.GDALDatasetCreateLayer(dataset_, "triangulation", reference, heights_ ? wkbPolygon25D : wkbPolygon,
                                          spatial_index ? nullptr : choices);
    if (layer_ == nullptr) return refused("cannot create its table");
    for (const char* name : fields) {
      const OGRFieldDefnH field = gdal_.OGR_Fld_Create(name, OFTInteger64);
      const bool added = gdal_.OGR_L_CreateField(layer_, field, 0) == OGRERR_NONE;
      gdal_.OGR_Fld_Destroy(field);
      if (!added) return refused("cannot create its table");
    }
    feature_ = gdal_.OGR_F_Create(gdal_.OGR_L_GetLayerDefn(layer_));
    if (gdal_.GDALDatasetStartTransaction(dataset_, 0) != OGRERR_NONE) return refused("cannot write");
    return success();
  }

  void release() {
    if (feature_ != nullptr) gdal_.OGR_F_Destroy(feature_);
    if (dataset_ != nullptr) gdal_.GDALClose(dataset_);
    feature_ = nullptr;
    dataset_ = nullptr;
  }

  const GdalLibrary& gdal_;
  GdalQuiet quiet_;
  fs::path path_;
  TemporaryFile temporary_;
  WkbTriangle triangle_;
  bool heights_;
  GDALDatasetH dataset_ = nullptr;
  OGRLayerH layer_ = nullptr;
  OGRFeatureH feature_ = nullptr;
  Status status_ = success();
};

}  // namespace

OpenedWriter open_geopackage(const fs::path& path, const MeshHead& head) { return GeoPackageWriter::open(path, head); }

}  // namespace tessera::exports
