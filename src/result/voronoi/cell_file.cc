#include "src/result/voronoi/cell_file.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <utility>

#include "src/base/crs/crs.h"
#include "src/base/json/json_text.h"
#include "src/result/export/ending.h"
#include "src/result/export/geopackage.h"
#include "src/result/export/output.h"
#include "src/result/voronoi/cell_fields.h"
#include "src/result/voronoi/flatgeobuf.h"

namespace tessera::voronoi {

namespace fs = std::filesystem;

namespace {

std::vector<exports::GeoPackage::Field> map_fields(const std::vector<Attribute>& schema) {
  std::vector<exports::GeoPackage::Field> fields{{"id", OFTInteger64},         {"area", OFTReal},
                                                 {"neighbours", OFTInteger64}, {"unbounded", OFTInteger, OFSTBoolean},
                                                 {"centroid_x", OFTReal},      {"centroid_y", OFTReal}};
  const auto names = attribute_fields(schema);
  for (std::size_t i = 0; i < names.size(); ++i)
    fields.push_back({names[i], is_real_type(schema[i].type) ? OFTReal : OFTInteger64});
  return fields;
}

// A layer of GDAL: `File` is GeoPackage or FlatGeobuf.
template <class File>
class MapCells : public CellFile {
 public:
  MapCells(std::unique_ptr<File> file, exports::GeoPackage::Layer layer, std::vector<Attribute> schema)
      : file_(std::move(file)), layer_(layer), schema_(std::move(schema)) {}

  Status add(const CellRecord& record) override {
    const GdalLibrary& gdal = file_->gdal();
    for_each_value(record, schema_, [&](int column, auto value) {
      if constexpr (is_real<decltype(value)>) {
        gdal.OGR_F_SetFieldDouble(layer_.feature, column, static_cast<double>(value));
      } else {
        gdal.OGR_F_SetFieldInteger64(layer_.feature, column, value);
      }
    });
    return file_->add(layer_, record.shape.data(), record.shape.size());
  }
  Result<std::uint64_t> finish() override { return file_->finish(); }

 private:
  std::unique_ptr<File> file_;
  exports::GeoPackage::Layer layer_;
  std::vector<Attribute> schema_;
};

// Reads the WKB that planar_cells.h makes.
class WkbText {
 public:
  // Signs of a text format around numbers: around a list, between items, around a corner, between its numbers.
  struct Signs {
    const char *open, *close, *corner_open, *corner_close, *between;
  };
  WkbText(exports::Stream& to, Signs signs) : to_(to), signs_(signs) {}

  // Writes the nested lists of numbers.
  void write(std::span<const std::byte> wkb) {
    at_ = wkb.data();
    geometry();
  }

 private:
  template <class Value>
  Value take() {
    Value value;
    std::memcpy(&value, at_, sizeof value);
    at_ += sizeof value;
    return value;
  }
  template <class Item>
  void list(const Item& item) {
    const auto count = take<std::uint32_t>();
    to_.text(signs_.open);
    for (std::uint32_t i = 0; i < count; ++i) {
      if (i > 0) to_.text(",");
      item();
    }
    to_.text(signs_.close);
  }
  void geometry() {
    at_ += 1;
    if (take<std::uint32_t>() == 6) return list([&] { geometry(); });
    list([&] {
      list([&] {
        to_.text(signs_.corner_open);
        to_.digits(take<double>());
        to_.text(signs_.between);
        to_.digits(take<double>());
        to_.text(signs_.corner_close);
      });
    });
  }

  exports::Stream& to_;
  Signs signs_;
  const std::byte* at_ = nullptr;
};

bool is_empty(std::span<const std::byte> wkb) { return wkb.size() <= 9; }

std::string quoted(const std::string& text) { return json_text(nlohmann::json(text)); }

class GeoJsonCells : public CellFile {
 public:
  GeoJsonCells(exports::OutputFile file, const std::string& crs, const CellFileOptions& options)
      : file_(std::move(file)),
        stream_(file_, 0),
        schema_(options.schema),
        wkb_(stream_, {"[", "]", "[", "]", ","}),
        type_(options.multi ? "MultiPolygon" : "Polygon") {
    for (const char* name : first_fields) keys_.push_back(quoted(name));
    for (const auto& name : attribute_fields(schema_)) keys_.push_back(quoted(name));
    stream_.text("{\"type\":\"FeatureCollection\",\"crs\":{\"type\":\"name\",\"properties\":{\"name\":" + quoted(crs) +
                 "}},\"result\":" + json_of(options.stamp) + ",\"features\":[");
  }

  Status add(const CellRecord& record) override {
    stream_.text(cells_++ == 0 ? "\n" : ",\n");
    stream_.text("{\"type\":\"Feature\",\"properties\":");
    for_each_value(record, schema_, [&](int column, auto value) {
      stream_.text(column == 0 ? "{" : ",");
      stream_.text(keys_[static_cast<std::size_t>(column)]);
      stream_.text(":");
      number(value);
    });
    if (is_empty(record.shape)) {
      stream_.text("},\"geometry\":null}");
      return stream_.status();
    }
    stream_.text("},\"geometry\":{\"type\":\"" + type_ + "\",\"coordinates\":");
    wkb_.write(record.shape);
    stream_.text("}}");
    return stream_.status();
  }
  Result<std::uint64_t> finish() override {
    stream_.text("\n]}\n");
    BOOST_OUTCOME_TRYV(stream_.flush());
    return file_.finish();
  }

 private:
  // JSON has no numbers that are not finite.
  template <class Value>
  void number(Value value) {
    if constexpr (std::is_same_v<Value, bool>) return stream_.text(value ? "true" : "false");
    if constexpr (std::is_floating_point_v<Value>) {
      if (!std::isfinite(value)) return stream_.text("null");
    }
    // Readers use doubles, and the shortest digits of a float would give another double.
    if constexpr (std::is_same_v<Value, float>) return stream_.digits(static_cast<double>(value));
    if constexpr (!std::is_same_v<Value, bool>) stream_.digits(value);
  }

  exports::OutputFile file_;
  exports::Stream stream_;
  std::vector<Attribute> schema_;
  WkbText wkb_;
  std::string type_;
  std::vector<std::string> keys_;
  std::uint64_t cells_ = 0;
};

// The shape is WKT in the column geom.
class CsvCells : public CellFile {
 public:
  CsvCells(exports::OutputFile file, const CellFileOptions& options)
      : file_(std::move(file)),
        stream_(file_, 0),
        schema_(options.schema),
        wkb_(stream_, {"(", ")", "", "", " "}),
        type_(options.multi ? "MULTIPOLYGON " : "POLYGON ") {
    stream_.text("geom");
    for (const char* name : first_fields) stream_.text(std::string(",") + name);
    for (const auto& name : attribute_fields(schema_)) stream_.text("," + field(name));
    stream_.text("\n");
  }

  Status add(const CellRecord& record) override {
    stream_.text("\"" + type_);
    if (is_empty(record.shape)) {
      stream_.text("EMPTY");
    } else {
      wkb_.write(record.shape);
    }
    stream_.text("\"");
    for_each_value(record, schema_, [&](int, auto value) {
      stream_.text(",");
      number(value);
    });
    stream_.text("\n");
    return stream_.status();
  }
  Result<std::uint64_t> finish() override {
    BOOST_OUTCOME_TRYV(stream_.flush());
    return file_.finish();
  }

 private:
  static std::string field(const std::string& name) {
    if (name.find_first_of("\",;") == std::string::npos) return name;
    std::string text = "\"";
    for (const char c : name) text += c == '"' ? std::string("\"\"") : std::string(1, c);
    return text + "\"";
  }
  // A value that is no number is an empty field.
  template <class Value>
  void number(Value value) {
    if constexpr (std::is_same_v<Value, bool>) return stream_.text(value ? "1" : "0");
    if constexpr (std::is_floating_point_v<Value>) {
      if (std::isnan(value)) return;
    }
    if constexpr (std::is_same_v<Value, float>) return stream_.digits(static_cast<double>(value));
    if constexpr (!std::is_same_v<Value, bool>) stream_.digits(value);
  }

  exports::OutputFile file_;
  exports::Stream stream_;
  std::vector<Attribute> schema_;
  WkbText wkb_;
  std::string type_;
};

template <class File>
Result<std::unique_ptr<CellFile>> create_map(Result<std::unique_ptr<File>> created, const CellFileOptions& options) {
  BOOST_OUTCOME_TRY(file, std::move(created));
  const auto type = options.multi ? wkbMultiPolygon : wkbPolygon;
  BOOST_OUTCOME_TRY(layer, file->add_layer("cells", type, map_fields(options.schema), true));
  BOOST_OUTCOME_TRYV(file->begin());
  return std::unique_ptr<CellFile>(std::make_unique<MapCells<File>>(std::move(file), layer, options.schema));
}

}  // namespace

Status CellFile::check_ending(const fs::path& target) {
  const std::string ending = exports::ending_of(target);
  for (const char* known : {".gpkg", ".fgb", ".geojson", ".json", ".csv"})
    if (ending == known) return success();
  return error(Errc::usage, target.string() +
                                ": cells of a 2D result are written as GeoPackage, FlatGeobuf, GeoJSON or CSV, so give "
                                "a name that ends in .gpkg, .fgb, .geojson or .csv");
}

Result<std::unique_ptr<CellFile>> CellFile::create(const fs::path& target, const CellFileOptions& options) {
  const std::string ending = exports::ending_of(target);
  if (ending == ".gpkg")
    return create_map(exports::GeoPackage::create(target, options.crs, metadata_of(options.stamp)), options);
  if (ending == ".fgb") return create_map(FlatGeobuf::create(target, options.crs), options);
  if (ending == ".csv") {
    BOOST_OUTCOME_TRY(file, exports::OutputFile::create(target));
    return std::unique_ptr<CellFile>(std::make_unique<CsvCells>(std::move(file), options));
  }
  BOOST_OUTCOME_TRY(crs, crs_name_or_wkt(options.crs));
  BOOST_OUTCOME_TRY(file, exports::OutputFile::create(target));
  return std::unique_ptr<CellFile>(std::make_unique<GeoJsonCells>(std::move(file), crs, options));
}

}  // namespace tessera::voronoi
