#include "src/result/alpha/shape_map.h"

#include <cstddef>
#include <cstring>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>
#include <vector>

#include "src/base/crs/crs.h"
#include "src/base/json/json_text.h"
#include "src/result/export/ending.h"
#include "src/result/export/geopackage.h"
#include "src/result/export/output.h"

namespace tessera::alpha {

namespace fs = std::filesystem;

namespace {

std::uint64_t vertices_of(const OutlineRings& rings) {
  std::uint64_t count = 0;
  for (const auto& ring : rings) count += ring.size();
  return count;
}

// A geometry as GDAL takes it: little endian, with ISO's type numbers.
class Wkb {
 public:
  void begin(std::uint32_t kind) {
    bytes_.assign(1, std::byte{1});
    put(kind);
  }
  template <class Value>
  void put(const Value& value) {
    const auto bytes = std::as_bytes(std::span(&value, 1));
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  }
  void put(double x, double y) {
    put(x);
    put(y);
  }
  const std::vector<std::byte>& bytes() const { return bytes_; }

 private:
  std::vector<std::byte> bytes_;
};

class GdalMap : public ShapeMap {
 public:
  static Result<std::unique_ptr<ShapeMap>> open(const fs::path& target, const std::string& crs,
                                                const ResultStamp& stamp, bool general) {
    using exports::GeoPackage;
    const bool is_package = exports::ending_of(target) == ".gpkg";
    BOOST_OUTCOME_TRY(file,
                      GeoPackage::create(target, crs, metadata_of(stamp),
                                         is_package ? GeoPackage::Kind::geopackage : GeoPackage::Kind::flatgeobuf));
    auto map = std::unique_ptr<GdalMap>(new GdalMap(std::move(file)));
    BOOST_OUTCOME_TRY(polygons, map->file_->add_layer("alpha_shape", wkbPolygon,
                                                      {{"vertices", OFTInteger64}, {"holes", OFTInteger64}}, true));
    map->polygons_ = polygons;
    if (general) {
      BOOST_OUTCOME_TRY(edges, map->file_->add_layer("singular_edges", wkbLineString, {}, true));
      BOOST_OUTCOME_TRY(vertices, map->file_->add_layer("singular_vertices", wkbPoint, {{"id", OFTInteger64}}, true));
      map->edges_ = edges;
      map->vertices_ = vertices;
    }
    BOOST_OUTCOME_TRYV(map->file_->begin());
    return std::unique_ptr<ShapeMap>(std::move(map));
  }

  Status polygon(const OutlineRings& rings) override {
    wkb_.begin(3);
    wkb_.put(static_cast<std::uint32_t>(rings.size()));
    for (const auto& ring : rings) {
      wkb_.put(static_cast<std::uint32_t>(ring.size() + 1));
      for (const OutlineVertex& vertex : ring) wkb_.put(vertex.x, vertex.y);
      wkb_.put(ring[0].x, ring[0].y);
    }
    set(polygons_, 0, vertices_of(rings));
    set(polygons_, 1, rings.size() - 1);
    return add(polygons_);
  }
  Status singular(const ShapeSimplex& simplex) override {
    if (simplex.kind == SimplexKind::singular_vertex) {
      wkb_.begin(1);
      wkb_.put(simplex.at[0].x, simplex.at[0].y);
      set(vertices_, 0, simplex.ids[0].value);
      return add(vertices_);
    }
    wkb_.begin(2);
    wkb_.put(std::uint32_t{2});
    for (std::size_t k = 0; k < 2; ++k) wkb_.put(simplex.at[k].x, simplex.at[k].y);
    return add(edges_);
  }
  Result<std::uint64_t> finish() override { return file_->finish(); }

 private:
  explicit GdalMap(std::unique_ptr<exports::GeoPackage> file) : file_(std::move(file)) {}
  void set(const exports::GeoPackage::Layer& layer, int field, std::uint64_t value) {
    file_->gdal().OGR_F_SetFieldInteger64(layer.feature, field, static_cast<GIntBig>(value));
  }
  Status add(const exports::GeoPackage::Layer& layer) {
    return file_->add(layer, wkb_.bytes().data(), wkb_.bytes().size());
  }

  std::unique_ptr<exports::GeoPackage> file_;
  exports::GeoPackage::Layer polygons_, edges_, vertices_;
  Wkb wkb_;
};

// RFC 7946: outer rings are counterclockwise. Coordinate systems other than longitude and latitude are named by the
// member "crs" of the specification of 2008.
class GeoJsonMap : public ShapeMap {
 public:
  GeoJsonMap(exports::OutputFile file, const std::string& crs, const ResultStamp& stamp)
      : file_(std::move(file)), stream_(file_, 0) {
    stream_.text("{\"type\":\"FeatureCollection\",\"crs\":{\"type\":\"name\",\"properties\":{\"name\":" +
                 json_text(nlohmann::json(crs)) + "}},\"result\":" + json_of(stamp) + ",\"features\":[");
  }

  Status polygon(const OutlineRings& rings) override {
    begin();
    stream_.text("\"vertices\":");
    stream_.digits(vertices_of(rings));
    stream_.text(",\"holes\":");
    stream_.digits(rings.size() - 1);
    stream_.text("},\"geometry\":{\"type\":\"Polygon\",\"coordinates\":[");
    for (std::size_t i = 0; i < rings.size(); ++i) {
      stream_.text(i == 0 ? "[" : ",[");
      for (std::size_t k = 0; k <= rings[i].size(); ++k) {
        if (k > 0) stream_.text(",");
        const OutlineVertex& vertex = rings[i][k % rings[i].size()];
        place(vertex.x, vertex.y);
      }
      stream_.text("]");
    }
    stream_.text("]}}");
    return stream_.status();
  }
  Status singular(const ShapeSimplex& simplex) override {
    begin();
    if (simplex.kind == SimplexKind::singular_vertex) {
      stream_.text("\"id\":");
      stream_.digits(simplex.ids[0].value);
      stream_.text("},\"geometry\":{\"type\":\"Point\",\"coordinates\":");
      place(simplex.at[0].x, simplex.at[0].y);
      stream_.text("}}");
      return stream_.status();
    }
    stream_.text("},\"geometry\":{\"type\":\"LineString\",\"coordinates\":[");
    place(simplex.at[0].x, simplex.at[0].y);
    stream_.text(",");
    place(simplex.at[1].x, simplex.at[1].y);
    stream_.text("]}}");
    return stream_.status();
  }
  Result<std::uint64_t> finish() override {
    stream_.text("\n]}\n");
    BOOST_OUTCOME_TRYV(stream_.flush());
    return file_.finish();
  }

 private:
  void begin() {
    stream_.text(features_++ == 0 ? "\n" : ",\n");
    stream_.text("{\"type\":\"Feature\",\"properties\":{");
  }
  void place(double x, double y) {
    stream_.text("[");
    stream_.digits(x);
    stream_.text(",");
    stream_.digits(y);
    stream_.text("]");
  }
  exports::OutputFile file_;
  exports::Stream stream_;
  std::uint64_t features_ = 0;
};

}  // namespace

bool ShapeMap::is_map(const fs::path& target) {
  const std::string ending = exports::ending_of(target);
  return ending == ".gpkg" || ending == ".geojson" || ending == ".json" || ending == ".fgb";
}

Result<std::unique_ptr<ShapeMap>> ShapeMap::create(const fs::path& target, const std::string& crs,
                                                   const ResultStamp& stamp, bool general) {
  const std::string ending = exports::ending_of(target);
  if (ending == ".gpkg" || ending == ".fgb") return GdalMap::open(target, crs, stamp, general);
  BOOST_OUTCOME_TRY(name, crs_name_or_wkt(crs));
  BOOST_OUTCOME_TRY(file, exports::OutputFile::create(target));
  return std::make_unique<GeoJsonMap>(std::move(file), name, stamp);
}

}  // namespace tessera::alpha
