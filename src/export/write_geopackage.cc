// GeoPackage, written by GDAL: one polygon a triangle in the table "triangulation", one point a vertex with its
// attributes in the table "vertices", if there are any, both with a spatial index. A table of their own, since each
// value is there once then and can be styled as it is; v0, v1 and v2 of a triangle are ids of vertices, which have an
// index.
#include <array>
#include <cctype>
#include <cstring>
#include <set>
#include <string>
#include <type_traits>
#include <vector>

#include "src/base/attribute_value.h"
#include "src/crs/gdal_library.h"
#include "src/export/formats.h"
#include "src/files/names.h"
#include "src/files/temporary.h"
#include "src/files/whole_file.h"

namespace tessera::exports {

namespace fs = std::filesystem;

namespace {

// What SQLite takes for the same is not.
std::string column_name(std::string name, std::set<std::string>& taken) {
  const auto lower = [](std::string text) {
    for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return text;
  };
  while (!taken.insert(lower(name)).second) name += '_';
  return name;
}

// The file has another name until it is whole, so it needs neither a journal nor to be synced at every step.
constexpr const char* options[] = {"OGR_SQLITE_SYNCHRONOUS", "OGR_SQLITE_JOURNAL"};

// A point as GDAL takes it: little endian, the numbers of ISO.
class WkbPoint {
 public:
  explicit WkbPoint(bool heights) : axes_(heights ? 3 : 2) {
    bytes_[0] = 1;
    const std::uint32_t kind = heights ? 1001U : 1U;
    std::memcpy(bytes_.data() + 1, &kind, sizeof kind);
  }
  const void* make(const Point& at) {
    std::memcpy(bytes_.data() + 5, &at, axes_ * sizeof(double));
    return bytes_.data();
  }
  int size() const { return 5 + static_cast<int>(axes_ * sizeof(double)); }

 private:
  std::size_t axes_;
  std::array<unsigned char, 5 + 24> bytes_{};
};

// A ring of four corners, the same way.
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
    auto writer = std::unique_ptr<GeoPackageWriter>(new GeoPackageWriter(*gdal, path, head));
    BOOST_OUTCOME_TRYV(writer->create(reference.get()));
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

  void vertex(const VertexView& vertex) override {
    if (!status_) return;
    gdal_.OGR_F_SetFieldInteger64(vertices_.feature, 0, static_cast<GIntBig>(vertex.id.value));
    for (std::size_t c = 0; c < head_.columns.size(); ++c) {
      const auto& column = head_.columns[c];
      const int field = static_cast<int>(c) + 1;
      visit_value(column.type, vertex.row + column.offset, [&](auto value) {
        if constexpr (is_real<decltype(value)>) {
          gdal_.OGR_F_SetFieldDouble(vertices_.feature, field, static_cast<double>(value));
        } else {
          gdal_.OGR_F_SetFieldInteger64(vertices_.feature, field, value);
        }
      });
    }
    add(vertices_, point_.make(vertex.at), point_.size());
  }
  void cell(const CellView& cell) override {
    if (!status_) return;
    gdal_.OGR_F_SetFieldInteger64(triangles_.feature, 0, cell.tile.value);
    for (int k = 0; k < 3; ++k)
      gdal_.OGR_F_SetFieldInteger64(triangles_.feature, k + 1,
                                    static_cast<GIntBig>(cell.ids[static_cast<std::size_t>(k)].value));
    add(triangles_, triangle_.make(cell), triangle_.size());
  }
  Status check() override { return status_; }

  Result<std::uint64_t> finish() override {
    BOOST_OUTCOME_TRYV(status_);
    if (gdal_.GDALDatasetCommitTransaction(dataset_) != OGRERR_NONE) return refused("cannot write");
    gdal_.CPLErrorReset();
    if (vertices_.layer != nullptr) {
      const char* index = "CREATE INDEX vertices_id ON vertices (id)";
      gdal_.GDALDatasetReleaseResultSet(dataset_, gdal_.GDALDatasetExecuteSQL(dataset_, index, nullptr, nullptr));
    }
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
  struct Layer {
    OGRLayerH layer = nullptr;
    OGRFeatureH feature = nullptr;  // filled anew for every row
  };
  struct Field {
    std::string name;
    OGRFieldType type;
  };
  // SQLite's integers have 64 bits and a sign.
  template <class Value>
  static constexpr bool is_real = std::is_floating_point_v<Value> || std::is_same_v<Value, std::uint64_t>;

  GeoPackageWriter(const GdalLibrary& gdal, const fs::path& path, const MeshHead& head)
      : gdal_(gdal),
        quiet_(gdal),
        path_(path),
        temporary_(temporary_name(path)),
        point_(head.heights),
        triangle_(head.heights),
        head_(head) {}

  // GDAL wants the ending.
  static fs::path temporary_name(const fs::path& path) { return tessera::temporary_name(path).string() + ".gpkg"; }

  Error refused(const std::string& what) const {
    return error(Errc::io, path_.string() + ": " + what + ": " + quiet_.message());
  }

  // Takes the fields of the layer's feature as they are set.
  void add(Layer& to, const void* wkb, int size) {
    OGRGeometryH geometry = nullptr;
    if (gdal_.OGR_G_CreateFromWkb(wkb, nullptr, &geometry, size) != OGRERR_NONE) {
      status_ = refused("cannot make a geometry");
      return;
    }
    gdal_.OGR_F_SetFID(to.feature, OGRNullFID);
    if (gdal_.OGR_F_SetGeometryDirectly(to.feature, geometry) != OGRERR_NONE ||
        gdal_.OGR_L_CreateFeature(to.layer, to.feature) != OGRERR_NONE)
      status_ = refused("cannot write");
  }

  Status create(OGRSpatialReferenceH reference) {
    gdal_.GDALAllRegister();
    std::error_code code;
    fs::remove(temporary_.path(), code);
    for (const char* option : options) gdal_.CPLSetThreadLocalConfigOption(option, "OFF");
    const GDALDriverH driver = gdal_.GDALGetDriverByName("GPKG");
    if (driver == nullptr) return error(Errc::io, "this GDAL cannot write GeoPackage");
    dataset_ = gdal_.GDALCreate(driver, temporary_.path().c_str(), 0, 0, 0, GDT_Unknown, nullptr);
    if (dataset_ == nullptr) return refused("cannot create");
    std::vector<Field> fields{{"tile", OFTInteger64}, {"v0", OFTInteger64}, {"v1", OFTInteger64}, {"v2", OFTInteger64}};
    BOOST_OUTCOME_TRYV(
        add_layer(triangles_, "triangulation", reference, head_.heights ? wkbPolygon25D : wkbPolygon, fields));
    if (!head_.columns.empty()) {
      fields = {{"id", OFTInteger64}};
      std::set<std::string> taken{"fid", "geom", "id"};
      for (const auto& column : head_.columns) {
        const std::byte any[sizeof(double)] = {};
        const bool real = visit_value(column.type, any, [](auto value) { return is_real<decltype(value)>; });
        fields.push_back({column_name(column.name, taken), real ? OFTReal : OFTInteger64});
      }
      BOOST_OUTCOME_TRYV(add_layer(vertices_, "vertices", reference, head_.heights ? wkbPoint25D : wkbPoint, fields));
    }
    if (gdal_.GDALDatasetStartTransaction(dataset_, 0) != OGRERR_NONE) return refused("cannot write");
    return success();
  }

  Status add_layer(Layer& to, const char* name, OGRSpatialReferenceH reference, OGRwkbGeometryType type,
                   const std::vector<Field>& fields) {
    char choice[] = "SPATIAL_INDEX=NO";
    char* choices[] = {choice, nullptr};
    to.layer = gdal_.GDALDatasetCreateLayer(dataset_, name, reference, type, head_.spatial_index ? nullptr : choices);
    if (to.layer == nullptr) return refused("cannot create its table");
    for (const auto& [title, kind] : fields) {
      const OGRFieldDefnH field = gdal_.OGR_Fld_Create(title.c_str(), kind);
      const bool added = gdal_.OGR_L_CreateField(to.layer, field, 0) == OGRERR_NONE;
      gdal_.OGR_Fld_Destroy(field);
      if (!added) return refused("cannot create its table");
    }
    // Makes the table now, not with its first row: the triangles are the first layer.
    if (gdal_.OGR_L_SyncToDisk(to.layer) != OGRERR_NONE) return refused("cannot create its table");
    to.feature = gdal_.OGR_F_Create(gdal_.OGR_L_GetLayerDefn(to.layer));
    return success();
  }

  void release() {
    for (Layer* layer : {&triangles_, &vertices_}) {
      if (layer->feature != nullptr) gdal_.OGR_F_Destroy(layer->feature);
      layer->feature = nullptr;
    }
    if (dataset_ != nullptr) gdal_.GDALClose(dataset_);
    dataset_ = nullptr;
  }

  const GdalLibrary& gdal_;
  GdalQuiet quiet_;
  fs::path path_;
  TemporaryFile temporary_;
  WkbPoint point_;
  WkbTriangle triangle_;
  MeshHead head_;
  GDALDatasetH dataset_ = nullptr;
  Layer triangles_, vertices_;
  Status status_ = success();
};

}  // namespace

OpenedWriter open_geopackage(const fs::path& path, const MeshHead& head) { return GeoPackageWriter::open(path, head); }

}  // namespace tessera::exports
