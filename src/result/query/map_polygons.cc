#include "src/result/query/map_polygons.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "src/base/crs/gdal_library.h"
#include "src/base/default_arithmetic.h"
#include "src/base/files/descriptor.h"
#include "src/base/ledger.h"
#include "src/base/option.h"
#include "src/base/printable.h"
#include "src/result/export/ending.h"

namespace tessera::query {

namespace fs = std::filesystem;

namespace {

using TakeFeature = std::function<Status(MapFeature&)>;
using Polygons = decltype(MapFeature::polygons);

class PolygonReader {
 public:
  PolygonReader(const GdalLibrary& gdal, const fs::path& path, const MapFileOptions& options, const TakeFeature& take)
      : gdal_(gdal), quiet_(gdal), path_(path), options_(options), take_(take) {}
  ~PolygonReader() {
    if (dataset_ != nullptr) gdal_.GDALClose(dataset_);
  }
  PolygonReader(const PolygonReader&) = delete;
  PolygonReader& operator=(const PolygonReader&) = delete;

  Status open() {
    BOOST_OUTCOME_TRYV(check_regular(path_));  // GDAL would wait for a named pipe
    const std::string ending = exports::ending_of(path_);
    const bool geojson = ending == ".geojson" || ending == ".json";
    if (geojson) {
      BOOST_OUTCOME_TRYV(check_no_links(path_));
    }
    const char* const text[] = {"GeoJSON", nullptr};
    const char* const binary[] = {"GPKG", "FlatGeobuf", "ESRI Shapefile", nullptr};
    dataset_ =
        gdal_.GDALOpenEx(path_.c_str(), GDAL_OF_VECTOR | GDAL_OF_READONLY, geojson ? text : binary, nullptr, nullptr);
    if (dataset_ == nullptr)
      return bad(std::string("GDAL cannot read polygons of it as ") +
                 (geojson ? "GeoJSON: " : "GeoPackage, FlatGeobuf or Shapefile: ") + quiet_.message());
    const int layers = gdal_.GDALDatasetGetLayerCount(dataset_);
    if (layers != 1) return bad("has " + std::to_string(layers) + " layers; give a file with one");
    layer_ = gdal_.GDALDatasetGetLayer(dataset_, 0);
    read_crs();
    return find_name();
  }

  Result<GeoJsonFrame> read() {
    for (OGRFeatureH feature = gdal_.OGR_L_GetNextFeature(layer_); feature != nullptr;
         feature = gdal_.OGR_L_GetNextFeature(layer_)) {
      const Status added = add(feature);
      gdal_.OGR_F_Destroy(feature);
      BOOST_OUTCOME_TRYV(added);
      gdal_.CPLErrorReset();
    }
    if (gdal_.CPLGetLastErrorType() >= CE_Failure)
      return error(Errc::io, path_.string() + ": cannot be read: " + quiet_.message());
    if (features_ == 0) return bad("has no polygon");
    return std::move(frame_);
  }

 private:
  Error bad(const std::string& why) const { return error(Errc::bad_input, path_.string() + ": " + why); }

  void read_crs() {
    frame_.name = path_.string();
    const OGRSpatialReferenceH reference = gdal_.OGR_L_GetSpatialRef(layer_);
    if (reference == nullptr) return;
    // GDAL says so of every GeoJSON that names no system; the numbers decide then (GeoJsonFrame).
    const char* const name = gdal_.OSRGetName(reference);
    if (std::string_view(gdal_.GDALGetDriverShortName(gdal_.GDALGetDatasetDriver(dataset_))) == "GeoJSON" &&
        gdal_.OSRIsGeographic(reference) != 0 && name != nullptr && std::string_view(name).starts_with("WGS 84"))
      return;
    char* text = nullptr;
    if (gdal_.OSRExportToWkt(reference, &text) == OGRERR_NONE && text != nullptr) frame_.crs = text;
    gdal_.VSIFree(text);
  }

  // Finds the attribute that names polygons.
  Status find_name() {
    const OGRFeatureDefnH definition = gdal_.OGR_L_GetLayerDefn(layer_);
    if (!options_.name.empty()) {
      name_ = gdal_.OGR_FD_GetFieldIndex(definition, options_.name.c_str());
      if (name_ >= 0) return success();
      std::string names;
      for (int i = 0; i < gdal_.OGR_FD_GetFieldCount(definition); ++i)
        names += (i == 0 ? "" : ", ") + printable(gdal_.OGR_Fld_GetNameRef(gdal_.OGR_FD_GetFieldDefn(definition, i)));
      return error(Errc::usage, option("name") + ": the polygons of " + path_.string() + " have no attribute " +
                                    in_quotes(options_.name) + "; they have " + (names.empty() ? "none" : names));
    }
    for (const char* usual : {"name", "id"}) {
      name_ = gdal_.OGR_FD_GetFieldIndex(definition, usual);
      if (name_ >= 0) break;
    }
    return success();
  }

  Status add(OGRFeatureH from) {
    MapFeature feature;
    feature.number = gdal_.OGR_F_GetFID(from);
    if (name_ >= 0 && gdal_.OGR_F_IsFieldSetAndNotNull(from, name_) != 0)
      feature.name = printable(gdal_.OGR_F_GetFieldAsString(from, name_));
    const auto refused = [&](const std::string& why) {
      return bad("feature " + std::to_string(feature.number) + " " + why);
    };
    const OGRGeometryH geometry = gdal_.OGR_F_GetGeometryRef(from);
    if (geometry == nullptr) return refused("has no geometry");
    if (const auto found = add_polygons(geometry, feature.polygons); !found) {
      if (found.error().code != Errc::bad_input) return found;
      return refused(found.error().where);
    }
    gdal_.CPLErrorReset();
    if (options_.must_be_valid && gdal_.OGR_G_IsValid(geometry) == 0)
      return refused("is not valid: " + quiet_.message());
    feature.wkb.resize(static_cast<std::size_t>(gdal_.OGR_G_WkbSize(geometry)));
    if (gdal_.OGR_G_ExportToIsoWkb(geometry, wkbNDR, reinterpret_cast<unsigned char*>(feature.wkb.data())) !=
        OGRERR_NONE)
      return refused("cannot be read: " + quiet_.message());
    ++features_;
    const Status taken = take_(feature);
    if (!taken && taken.error().code == Errc::bad_input) return refused(taken.error().where);
    return taken;
  }

  // Errors bad_input are the end of a sentence about the feature.
  Status add_polygons(OGRGeometryH geometry, Polygons& polygons) {
    const auto kind = gdal_.OGR_G_GetGeometryType(geometry);
    const auto flat = gdal_.OGR_GT_Flatten(kind);
    if (flat != wkbPolygon && flat != wkbMultiPolygon)
      return error(Errc::bad_input, std::string("is a ") + gdal_.OGR_G_GetGeometryName(geometry) + ", not a polygon");
    if (options_.heights && gdal_.OGR_GT_HasZ(kind) == 0)
      return error(Errc::bad_input, "has no heights: a base needs a z for each vertex");
    const int parts = gdal_.OGR_G_GetGeometryCount(geometry);
    if (parts == 0) return error(Errc::bad_input, "is empty");
    if (flat == wkbPolygon) polygons.emplace_back();
    for (int i = 0; i < parts; ++i) {
      const OGRGeometryH part = gdal_.OGR_G_GetGeometryRef(geometry, i);
      if (flat == wkbMultiPolygon) {
        BOOST_OUTCOME_TRYV(add_polygons(part, polygons));
      } else {
        BOOST_OUTCOME_TRYV(add_ring(part, polygons.back()));
      }
    }
    return success();
  }

  Status add_ring(OGRGeometryH from, std::vector<std::vector<Point>>& rings) {
    const auto count = static_cast<std::size_t>(std::max(gdal_.OGR_G_GetPointCount(from), 0));
    vertices_ += count;
    const std::uint64_t each = options_.bytes_of_vertex;
    if (options_.bytes_max > 0 && vertices_ > options_.bytes_max / each)
      return error(Errc::memory, path_.string() + ": its polygons have more than " +
                                     std::to_string(options_.bytes_max / each) +
                                     " vertices, too many for the memory; give more " + option("memory"));
    BOOST_OUTCOME_TRYV(Ledger::draw_memory(count * each));
    std::vector<Point> ring(count);
    if (count > 0)
      gdal_.OGR_G_GetPoints(from, &ring[0].x, sizeof(Point), &ring[0].y, sizeof(Point), &ring[0].z, sizeof(Point));
    for (std::size_t i = 0; i < count; ++i) {
      if (!options_.heights) ring[i].z = 0;
      if (!is_finite(ring[i]))
        return error(Errc::bad_input,
                     "has a vertex with a coordinate that is not finite, vertex " + std::to_string(i) + " of a ring");
      ring[i] = without_negative_zero(ring[i]);
      frame_.bounds.add(ring[i]);
    }
    if (count > 1 && ring.front().x == ring.back().x && ring.front().y == ring.back().y) {
      if (ring.front().z != ring.back().z)
        return error(Errc::bad_input, "has two vertices at one place with different heights");
      ring.pop_back();
    }
    if (ring.size() < 3) return error(Errc::bad_input, "has a ring of fewer than three vertices");
    rings.push_back(std::move(ring));
    return success();
  }

  const GdalLibrary& gdal_;
  GdalQuiet quiet_;
  const fs::path& path_;
  const MapFileOptions& options_;
  const TakeFeature& take_;
  GDALDatasetH dataset_ = nullptr;
  OGRLayerH layer_ = nullptr;
  int name_ = -1;
  std::uint64_t vertices_ = 0, features_ = 0;
  GeoJsonFrame frame_;
};

}  // namespace

Result<GeoJsonFrame> read_map_polygons(const fs::path& path, const MapFileOptions& options, const TakeFeature& take) {
  BOOST_OUTCOME_TRY(gdal, gdal_library());
  const DefaultArithmetic kept;
  PolygonReader reader(*gdal, path, options, take);
  BOOST_OUTCOME_TRYV(reader.open());
  return reader.read();
}

}  // namespace tessera::query
