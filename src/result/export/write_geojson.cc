// GeoJSON: a FeatureCollection with one polygon a triangle. The writer is our own, because GDAL's loses bits even with
// 17 digits (6277550.010000001 becomes 6277550.01) and takes ten times as long. GDAL is asked only for the coordinate
// system. RFC 7946 allows only longitude and latitude. Other systems are named by the "crs" member of the 2008
// specification, which GDAL and QGIS read.
//
// A file is one layer, so triangles have the attributes of their corners: intensity_0 is that of v0. There is one
// property for each corner, because QGIS styles by numbers, not by lists. There are no means, because the mean of two
// classes is another class.
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <type_traits>
#include <vector>

#include "src/base/attribute_value.h"
#include "src/base/crs/crs.h"
#include "src/base/json/json_text.h"
#include "src/result/export/formats.h"
#include "src/result/export/stream_writer.h"

namespace tessera::exports {

namespace {

std::string quoted(const std::string& text) { return json_text(nlohmann::json(text)); }

class GeoJsonWriter : public StreamWriter {
 public:
  GeoJsonWriter(OutputFile file, const MeshHead& head, const std::string& crs)
      : StreamWriter(std::move(file)),
        heights_(head.heights),
        final_(head.final),
        columns_(head.columns),
        cell_columns_(head.cell_columns) {
    stream_.text("{\"type\":\"FeatureCollection\",\"crs\":{\"type\":\"name\",\"properties\":{\"name\":" + quoted(crs) +
                 "}}" + (head.stamp ? ",\"result\":" + json_of(*head.stamp) : "") + ",\"features\":[");
    for (const auto& column : cell_columns_) cell_keys_.push_back("," + quoted(column.name) + ":");
    // The keys differ from each other as the attributes' names do; "tile" and "v0" end differently.
    for (const auto& column : columns_)
      for (std::size_t k = 0; k < 3; ++k) keys_.push_back("," + quoted(column.name + "_" + std::to_string(k)) + ":");
  }

  void vertex(const VertexView&) override {}
  void cell(const CellView& cell) override {
    stream_.text(cells_++ == 0 ? "\n" : ",\n");
    stream_.text("{\"type\":\"Feature\",\"properties\":{\"tile\":");
    stream_.digits(cell.tile.value);
    for (std::size_t k = 0; k < 3; ++k) {
      stream_.text(names[k]);
      stream_.digits(cell.ids[k].value);
    }
    if (final_) stream_.text(cell.final ? ",\"final\":1" : ",\"final\":0");
    for (std::size_t c = 0; c < cell_columns_.size(); ++c) {
      stream_.text(cell_keys_[c]);
      visit_value(cell_columns_[c].type, cell.values[c], [&](auto value) { number(value); });
    }
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      for (std::size_t k = 0; k < 3; ++k) {
        stream_.text(keys_[3 * c + k]);
        visit_value(columns_[c].type, cell.rows[k] + columns_[c].offset, [&](auto value) { number(value); });
      }
    }
    stream_.text("},\"geometry\":{\"type\":\"Polygon\",\"coordinates\":[[");
    for (std::size_t k = 0; k < 4; ++k) {  // a ring ends where it began
      const Point& p = cell.at[k % 3];
      stream_.text(k == 0 ? "[" : ",[");
      stream_.digits(p.x);
      stream_.text(",");
      stream_.digits(p.y);
      if (heights_) {
        stream_.text(",");
        stream_.digits(p.z);
      }
      stream_.text("]");
    }
    stream_.text("]]}}");
  }

 private:
  void end() override { stream_.text("\n]}\n"); }
  template <class Value>
  void number(Value value) {
    if constexpr (std::is_floating_point_v<Value>) {
      if (!std::isfinite(value)) return stream_.text("null");  // JSON has no other value
    }
    // Readers use doubles, and the shortest digits of a float would give another double.
    if constexpr (std::is_same_v<Value, float>) return stream_.digits(static_cast<double>(value));
    stream_.digits(value);
  }
  static constexpr const char* names[] = {",\"v0\":", ",\"v1\":", ",\"v2\":"};
  bool heights_, final_;
  std::vector<Column> columns_;
  std::vector<Attribute> cell_columns_;
  std::vector<std::string> cell_keys_;
  std::vector<std::string> keys_;  // three keys a column
  std::uint64_t cells_ = 0;
};

}  // namespace

OpenedWriter open_geojson(const std::filesystem::path& path, const MeshHead& head) {
  BOOST_OUTCOME_TRY(crs, crs_name_or_wkt(head.crs));
  BOOST_OUTCOME_TRY(file, OutputFile::create(path));
  return std::make_unique<GeoJsonWriter>(std::move(file), head, crs);
}

}  // namespace tessera::exports
