// GeoPackage, written by GDAL: one polygon a triangle in the table "triangulation"; if vertices have attributes, one
// point a vertex in the table "vertices"; both with a spatial index. Vertices have a table of their own, so that each
// value is there once and can be styled as it is. v0, v1 and v2 of a triangle are ids of vertices, which have an index.
#include <array>
#include <cstring>
#include <memory>
#include <set>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "src/base/attribute_value.h"
#include "src/result/export/field_name.h"
#include "src/result/export/formats.h"
#include "src/result/export/geopackage.h"

namespace tessera::exports {

namespace fs = std::filesystem;

namespace {

// A point as GDAL takes it: little endian, with ISO's type numbers.
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
  std::size_t size() const { return 5 + axes_ * sizeof(double); }

 private:
  std::size_t axes_;
  std::array<unsigned char, 5 + 24> bytes_{};
};

// A ring of four corners in the same format.
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
  std::size_t size() const { return 13 + 4 * axes_ * sizeof(double); }

 private:
  std::size_t axes_;
  std::array<unsigned char, 13 + 96> bytes_{};
};

class GeoPackageWriter : public MeshWriter {
 public:
  static OpenedWriter open(const fs::path& path, const MeshHead& head) {
    BOOST_OUTCOME_TRY(file,
                      GeoPackage::create(path, head.crs, head.stamp ? metadata_of(*head.stamp) : MetadataItems{}));
    auto writer = std::unique_ptr<GeoPackageWriter>(new GeoPackageWriter(std::move(file), head));
    BOOST_OUTCOME_TRYV(writer->create());
    return std::unique_ptr<MeshWriter>(std::move(writer));
  }

  void vertex(const VertexView& vertex) override {
    if (!status_) return;
    gdal_.OGR_F_SetFieldInteger64(vertices_.feature, 0, static_cast<GIntBig>(vertex.id.value));
    for (std::size_t c = 0; c < head_.columns.size(); ++c) {
      const auto& column = head_.columns[c];
      set(vertices_, static_cast<int>(c) + 1, column.type, vertex.row + column.offset);
    }
    status_ = file_->add(vertices_, point_.make(vertex.at), point_.size());
  }
  void cell(const CellView& cell) override {
    if (!status_) return;
    gdal_.OGR_F_SetFieldInteger64(triangles_.feature, 0, cell.tile.value);
    for (int k = 0; k < 3; ++k)
      gdal_.OGR_F_SetFieldInteger64(triangles_.feature, k + 1,
                                    static_cast<GIntBig>(cell.ids[static_cast<std::size_t>(k)].value));
    for (std::size_t c = 0; c < head_.cell_columns.size(); ++c)
      set(triangles_, static_cast<int>(c) + 4, head_.cell_columns[c].type, cell.values[c]);
    status_ = file_->add(triangles_, triangle_.make(cell), triangle_.size());
  }
  Status check() override { return status_; }

  Result<std::uint64_t> finish() override {
    BOOST_OUTCOME_TRYV(status_);
    return file_->finish(vertices_.layer != nullptr ? "CREATE INDEX vertices_id ON vertices (id)" : nullptr);
  }

 private:
  // SQLite's integers have 64 bits and a sign.
  template <class Value>
  static constexpr bool is_real = std::is_floating_point_v<Value> || std::is_same_v<Value, std::uint64_t>;

  GeoPackageWriter(std::unique_ptr<GeoPackage> file, const MeshHead& head)
      : file_(std::move(file)), gdal_(file_->gdal()), point_(head.heights), triangle_(head.heights), head_(head) {}

  void set(const GeoPackage::Layer& layer, int field, AttributeType type, const std::byte* at) {
    visit_value(type, at, [&](auto value) {
      if constexpr (is_real<decltype(value)>) {
        gdal_.OGR_F_SetFieldDouble(layer.feature, field, static_cast<double>(value));
      } else {
        gdal_.OGR_F_SetFieldInteger64(layer.feature, field, value);
      }
    });
  }
  static OGRFieldType field_type(AttributeType type) {
    const std::byte any[sizeof(double)] = {};
    return visit_value(type, any, [](auto value) { return is_real<decltype(value)>; }) ? OFTReal : OFTInteger64;
  }

  Status create() {
    std::vector<GeoPackage::Field> fields{
        {"tile", OFTInteger64}, {"v0", OFTInteger64}, {"v1", OFTInteger64}, {"v2", OFTInteger64}};
    std::set<std::string> of_triangles{"fid", "geom", "tile", "v0", "v1", "v2"};
    for (const auto& column : head_.cell_columns)
      fields.push_back({field_name(column.name, of_triangles), field_type(column.type)});
    BOOST_OUTCOME_TRY(triangles, file_->add_layer("triangulation", head_.heights ? wkbPolygon25D : wkbPolygon, fields,
                                                  head_.spatial_index));
    triangles_ = triangles;
    if (!head_.columns.empty()) {
      fields = {{"id", OFTInteger64}};
      std::set<std::string> taken{"fid", "geom", "id"};
      for (const auto& column : head_.columns) {
        fields.push_back({field_name(column.name, taken), field_type(column.type)});
      }
      BOOST_OUTCOME_TRY(
          vertices, file_->add_layer("vertices", head_.heights ? wkbPoint25D : wkbPoint, fields, head_.spatial_index));
      vertices_ = vertices;
    }
    return file_->begin();
  }

  std::unique_ptr<GeoPackage> file_;
  const GdalLibrary& gdal_;
  WkbPoint point_;
  WkbTriangle triangle_;
  MeshHead head_;
  GeoPackage::Layer triangles_, vertices_;
  Status status_ = success();
};

}  // namespace

OpenedWriter open_geopackage(const fs::path& path, const MeshHead& head) { return GeoPackageWriter::open(path, head); }

}  // namespace tessera::exports
