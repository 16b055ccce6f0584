#include "src/result/terrain/line_reader.h"

#include <algorithm>
#include <charconv>
#include <utility>

#include "src/base/default_arithmetic.h"
#include "src/base/files/descriptor.h"

namespace tessera::terrain {
namespace {

constexpr const char* layer_name = "contours";

std::string text_of(auto number) {
  char digits[32];
  return {digits, std::to_chars(digits, digits + sizeof digits, number).ptr};
}

std::string quoted_name(const std::string& name) {
  std::string text = "\"";
  for (const char c : name) text += c == '"' ? std::string("\"\"") : std::string(1, c);
  return text + "\"";
}

}  // namespace

LineReader::~LineReader() {
  const GdalQuiet quiet(gdal_);
  gdal_.GDALClose(dataset_);
}

Result<std::unique_ptr<LineReader>> LineReader::open(const std::filesystem::path& path) {
  BOOST_OUTCOME_TRY(gdal, gdal_library());
  const DefaultArithmetic kept;
  const GdalQuiet quiet(*gdal);
  const auto refused = [&] { return error(Errc::usage, path.string() + ": holds no contour lines"); };
  if (!check_regular(path)) return refused();  // GDAL would wait for a named pipe
  const char* const drivers[] = {"GPKG", nullptr};
  // The file may be replaced as a whole, but is never changed.
  const char* const choices[] = {"IMMUTABLE=YES", nullptr};
  const GDALDatasetH dataset =
      gdal->GDALOpenEx(path.c_str(), GDAL_OF_VECTOR | GDAL_OF_READONLY, drivers, choices, nullptr);
  if (dataset == nullptr) return refused();
  auto reader = std::unique_ptr<LineReader>(new LineReader(*gdal, dataset));
  reader->layer_ = gdal->GDALDatasetGetLayerByName(dataset, layer_name);
  if (reader->layer_ == nullptr) return refused();
  const OGRFeatureDefnH definition = gdal->OGR_L_GetLayerDefn(reader->layer_);
  const auto type = gdal->OGR_L_GetGeomType(reader->layer_);
  const int fields = gdal->OGR_FD_GetFieldCount(definition);
  if ((type != wkbLineString && type != wkbLineString25D) || fields < 1 || fields > 2) return refused();
  reader->value_name_ = gdal->OGR_Fld_GetNameRef(gdal->OGR_FD_GetFieldDefn(definition, 0));
  if (fields == 2) reader->index_name_ = gdal->OGR_Fld_GetNameRef(gdal->OGR_FD_GetFieldDefn(definition, 1));
  return reader;
}

std::uint64_t LineReader::lines() const {
  const GdalQuiet quiet(gdal_);
  return static_cast<std::uint64_t>(std::max<GIntBig>(gdal_.OGR_L_GetFeatureCount(layer_, 1), 0));
}

Status LineReader::for_each(std::uint64_t after, const std::optional<Bounds>& box,
                            const std::function<Result<bool>(Line& line)>& visit) const {
  const DefaultArithmetic kept;
  const GdalQuiet quiet(gdal_);
  // The names of the columns are those that GDAL gives in files that we write.
  std::string sql = "SELECT fid AS line_number, " + quoted_name(value_name_) + " AS line_value, " +
                    (index_name_.empty() ? "NULL" : quoted_name(index_name_)) +
                    " AS line_index, geom FROM contours WHERE fid > " + text_of(after);
  if (box)
    sql += " AND fid IN (SELECT id FROM rtree_contours_geom WHERE maxx >= " + text_of(box->lo.x) +
           " AND minx <= " + text_of(box->hi.x) + " AND maxy >= " + text_of(box->lo.y) +
           " AND miny <= " + text_of(box->hi.y) + ")";
  sql += " ORDER BY fid";
  const OGRLayerH found = gdal_.GDALDatasetExecuteSQL(dataset_, sql.c_str(), nullptr, nullptr);
  if (found == nullptr) return error(Errc::io, "contour lines cannot be read: " + quiet.message());
  const OGRFeatureDefnH definition = gdal_.OGR_L_GetLayerDefn(found);
  const int number = gdal_.OGR_FD_GetFieldIndex(definition, "line_number");
  const int value = gdal_.OGR_FD_GetFieldIndex(definition, "line_value");
  const int index = gdal_.OGR_FD_GetFieldIndex(definition, "line_index");
  Status status = success();
  Line line;
  for (OGRFeatureH feature = gdal_.OGR_L_GetNextFeature(found); feature != nullptr;
       feature = gdal_.OGR_L_GetNextFeature(found)) {
    line.number = number < 0 ? static_cast<std::uint64_t>(gdal_.OGR_F_GetFID(feature))
                             : static_cast<std::uint64_t>(gdal_.OGR_F_GetFieldAsInteger64(feature, number));
    line.value = gdal_.OGR_F_GetFieldAsDouble(feature, value);
    if (!index_name_.empty()) line.index = gdal_.OGR_F_GetFieldAsInteger64(feature, index) != 0;
    const OGRGeometryH geometry = gdal_.OGR_F_GetGeometryRef(feature);
    line.points.assign(geometry == nullptr ? 0 : static_cast<std::size_t>(gdal_.OGR_G_GetPointCount(geometry)),
                       Point{});
    if (!line.points.empty())
      gdal_.OGR_G_GetPoints(geometry, &line.points[0].x, sizeof(Point), &line.points[0].y, sizeof(Point),
                            &line.points[0].z, sizeof(Point));
    gdal_.OGR_F_Destroy(feature);
    const auto more = visit(line);
    if (!more) status = more.error();
    if (!more || !more.value()) break;
  }
  gdal_.GDALDatasetReleaseResultSet(dataset_, found);
  return status;
}

}  // namespace tessera::terrain
