#include "src/result/voronoi/read_clip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string>
#include <string_view>
#include <utility>

#include "src/base/crs/crs.h"
#include "src/base/crs/gdal_library.h"
#include "src/base/default_arithmetic.h"
#include "src/base/files/descriptor.h"
#include "src/base/ledger.h"
#include "src/base/option.h"
#include "src/result/export/ending.h"
#include "src/result/query/geojson.h"
#include "src/result/query/hull.h"

namespace tessera::voronoi {

namespace fs = std::filesystem;

namespace {

// Adds polygons to a region, within the memory of the ledger.
class RegionMaker {
 public:
  Status add(std::span<const std::vector<Point>> rings) {
    std::uint64_t edges = 0;
    for (const auto& ring : rings) edges += ring.size();
    edges_ += edges;
    if (edges_ >= edges_max)
      return error(Errc::memory, "the polygons have more than " + std::to_string(edges_max) + " edges");
    BOOST_OUTCOME_TRYV(Ledger::draw_memory(edges * ClipRegion::bytes_of_edge));
    region_.add(rings);
    return success();
  }
  ClipRegion finish() {
    region_.index();
    return std::move(region_);
  }
  std::uint64_t edges() const { return edges_; }

 private:
  static constexpr std::uint64_t edges_max = std::uint64_t{1} << 28;
  ClipRegion region_;
  std::uint64_t edges_ = 0;
};

// Reads polygons from well-known binary, little endian, with the numbers of types of ISO. Heights are left out.
class WkbPolygons {
 public:
  explicit WkbPolygons(std::span<const std::byte> bytes) : bytes_(bytes) {}

  // Errors are the end of a sentence.
  template <class Take>
  Status read(const Take& take) {
    BOOST_OUTCOME_TRY(order, number<std::uint8_t>());
    if (order != 1) return error(Errc::bad_input, "has a geometry that cannot be read");
    BOOST_OUTCOME_TRY(type, number<std::uint32_t>());
    const std::uint32_t kind = type % 1000, axes = type / 1000 == 0 ? 2 : (type / 1000 == 3 ? 4 : 3);
    if (kind != 3 && kind != 6) return error(Errc::bad_input, "is neither Polygon nor MultiPolygon");
    BOOST_OUTCOME_TRY(count, number<std::uint32_t>());
    if (kind == 6) {
      for (std::uint32_t i = 0; i < count; ++i) {
        BOOST_OUTCOME_TRYV(read(take));
      }
      return success();
    }
    std::vector<std::vector<Point>> rings;
    for (std::uint32_t i = 0; i < count; ++i) {
      BOOST_OUTCOME_TRY(ring, corners(axes));
      rings.push_back(std::move(ring));
    }
    return take(rings);
  }

 private:
  template <class Number>
  Result<Number> number() {
    Number value{};
    if (bytes_.size() < sizeof value) return error(Errc::bad_input, "has a geometry that cannot be read");
    std::memcpy(&value, bytes_.data(), sizeof value);
    bytes_ = bytes_.subspan(sizeof value);
    return value;
  }
  Result<std::vector<Point>> corners(std::uint32_t axes) {
    BOOST_OUTCOME_TRY(count, number<std::uint32_t>());
    std::vector<Point> ring;
    for (std::uint32_t i = 0; i < count; ++i) {
      Point p{};
      for (std::uint32_t axis = 0; axis < axes; ++axis) {
        BOOST_OUTCOME_TRY(value, number<double>());
        if (axis < 2) p[static_cast<int>(axis)] = value;
      }
      if (!std::isfinite(p.x) || !std::isfinite(p.y))
        return error(Errc::bad_input, "has a coordinate that is not finite");
      ring.push_back(without_negative_zero(p));
    }
    if (ring.size() > 1 && ring.front().x == ring.back().x && ring.front().y == ring.back().y) ring.pop_back();
    return ring;
  }

  std::span<const std::byte> bytes_;
};

// An open file of GDAL.
class PolygonFile {
 public:
  static Result<std::unique_ptr<PolygonFile>> open(const fs::path& path, const char* driver) {
    BOOST_OUTCOME_TRY(gdal, gdal_library());
    BOOST_OUTCOME_TRYV(check_regular(path));  // GDAL would wait for a named pipe
    auto file = std::unique_ptr<PolygonFile>(new PolygonFile(*gdal));
    const char* const drivers[] = {driver, nullptr};
    file->dataset_ = gdal->GDALOpenEx(path.c_str(), GDAL_OF_VECTOR | GDAL_OF_READONLY, drivers, nullptr, nullptr);
    if (file->dataset_ == nullptr)
      return error(Errc::bad_input, path.string() + ": cannot be read as " + driver + ": " + file->quiet_.message());
    const int layers = gdal->GDALDatasetGetLayerCount(file->dataset_);
    if (layers != 1)
      return error(Errc::bad_input, path.string() + ": has " + std::to_string(layers) +
                                        " layers; give a file with one layer of polygons");
    file->layer_ = gdal->GDALDatasetGetLayer(file->dataset_, 0);
    return file;
  }
  ~PolygonFile() {
    if (dataset_ != nullptr) gdal_.GDALClose(dataset_);
  }
  PolygonFile(const PolygonFile&) = delete;
  PolygonFile& operator=(const PolygonFile&) = delete;

  // As WKT; empty when there is none.
  std::string crs() const {
    const OGRSpatialReferenceH reference = gdal_.OGR_L_GetSpatialRef(layer_);
    if (reference == nullptr) return {};
    char* text = nullptr;
    const bool written = gdal_.OSRExportToWkt(reference, &text) == OGRERR_NONE;
    std::string wkt = written ? text : "";
    gdal_.VSIFree(text);
    return wkt;
  }

  // Calls take(rings) for each polygon. Errors are the end of a sentence.
  template <class Take>
  Status for_each(const Take& take) {
    std::vector<std::byte> wkb;
    gdal_.CPLErrorReset();
    for (OGRFeatureH feature = gdal_.OGR_L_GetNextFeature(layer_); feature != nullptr;
         feature = gdal_.OGR_L_GetNextFeature(layer_)) {
      const std::string name = "feature " + std::to_string(gdal_.OGR_F_GetFID(feature)) + " ";
      const OGRGeometryH geometry = gdal_.OGR_F_GetGeometryRef(feature);
      Status status = success();
      if (geometry != nullptr) {
        wkb.resize(static_cast<std::size_t>(gdal_.OGR_G_WkbSize(geometry)));
        gdal_.OGR_G_ExportToIsoWkb(geometry, wkbNDR, reinterpret_cast<unsigned char*>(wkb.data()));
        status = WkbPolygons(wkb).read(take);
      }
      gdal_.OGR_F_Destroy(feature);
      if (!status) return error(status.error().code, name + status.error().where);
    }
    if (gdal_.CPLGetLastErrorType() >= CE_Failure) return error(Errc::io, "cannot be read: " + quiet_.message());
    return success();
  }

 private:
  explicit PolygonFile(const GdalLibrary& gdal) : gdal_(gdal), quiet_(gdal) {}
  const DefaultArithmetic kept_;
  const GdalLibrary& gdal_;
  GdalQuiet quiet_;
  GDALDatasetH dataset_ = nullptr;
  OGRLayerH layer_ = nullptr;
};

Result<ClipRegion> map_region(const fs::path& path, const char* driver, const Manifest& manifest) {
  BOOST_OUTCOME_TRY(file, PolygonFile::open(path, driver));
  if (const std::string crs = file->crs(); surely_other_crs(crs, manifest.crs))
    return error(Errc::bad_input, path.string() + ": its coordinates are those of " + crs_title(crs) +
                                      ", and the points have those of " + crs_title(manifest.crs) +
                                      "; transform it first, as ogr2ogr -t_srs does");
  RegionMaker maker;
  const auto read =
      file->for_each([&](std::span<const std::vector<Point>> rings) -> Status { return maker.add(rings); });
  if (!read) return error(read.error().code, path.string() + ": " + read.error().where);
  if (maker.edges() == 0) return error(Errc::bad_input, path.string() + ": has no polygon");
  return maker.finish();
}

Result<ClipRegion> geojson_region(const fs::path& path, const Manifest& manifest) {
  BOOST_OUTCOME_TRY(shapes, query::read_geojson(path, query::GeoJson::polygons));
  BOOST_OUTCOME_TRYV(shapes.place.check_in(manifest.crs, manifest.bounds));
  RegionMaker maker;
  const std::span<const std::vector<Point>> rings = shapes.lists;
  for (std::size_t i = 0; i < shapes.firsts.size(); ++i) {
    const std::size_t end = i + 1 < shapes.firsts.size() ? shapes.firsts[i + 1] : rings.size();
    BOOST_OUTCOME_TRYV(maker.add(rings.subspan(shapes.firsts[i], end - shapes.firsts[i])));
  }
  return maker.finish();
}

}  // namespace

Result<ClipRegion> hull_region(const TileSource& source, const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(hull, query::hull_of(source, stop));
  ClipRegion region;
  region.set_convex();
  region.add(std::span(&hull, 1));
  region.index();
  return region;
}

Result<ClipRegion> box_region(const Bounds& box) {
  const auto is_finite = [](const Point& p) { return std::isfinite(p.x) && std::isfinite(p.y); };
  if (!is_finite(box.lo) || !is_finite(box.hi) || !(box.lo.x < box.hi.x) || !(box.lo.y < box.hi.y))
    return error(Errc::usage, option("clip") + ": the box has no area; each side needs two different finite numbers");
  const std::vector<Point> ring{
      {box.lo.x, box.lo.y, 0}, {box.hi.x, box.lo.y, 0}, {box.hi.x, box.hi.y, 0}, {box.lo.x, box.hi.y, 0}};
  ClipRegion region;
  region.set_convex();
  region.add(std::span(&ring, 1));
  region.index();
  return region;
}

bool is_region_file(const fs::path& path) {
  constexpr std::array<std::string_view, 5> endings{".gpkg", ".fgb", ".shp", ".geojson", ".json"};
  return std::find(endings.begin(), endings.end(), exports::ending_of(path)) != endings.end();
}

Result<ClipRegion> file_region(const fs::path& path, const Manifest& manifest) {
  const std::string ending = exports::ending_of(path);
  if (ending == ".gpkg") return map_region(path, "GPKG", manifest);
  if (ending == ".fgb") return map_region(path, "FlatGeobuf", manifest);
  if (ending == ".shp") return map_region(path, "ESRI Shapefile", manifest);
  if (ending == ".geojson" || ending == ".json") return geojson_region(path, manifest);
  return error(Errc::usage, path.string() + ": is no file of polygons by its ending, .gpkg, .fgb, .shp or .geojson");
}

}  // namespace tessera::voronoi
