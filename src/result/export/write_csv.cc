// CSV with the triangles as WKT polygons, and OGR's VRT, which makes layers of such tables. The QGIS projects of the
// paper's authors consist of these (columns geom; tid: the tile; local: how many vertices are the tile's own; main).
// Writing needs no GDAL.
#include <algorithm>
#include <cmath>
#include <set>
#include <type_traits>

#include "src/base/attribute_value.h"
#include "src/base/crs/crs.h"
#include "src/base/utf8.h"
#include "src/result/export/field_name.h"
#include "src/result/export/formats.h"
#include "src/result/export/stream_writer.h"

namespace tessera::exports {

namespace {

constexpr const char* first_fields[] = {"tid", "local", "main", "v0", "v1", "v2"};

// The names of the columns of cells.
std::vector<std::string> cell_fields(const MeshHead& head) {
  std::set<std::string> taken{"geom"};
  taken.insert(std::begin(first_fields), std::end(first_fields));
  std::vector<std::string> names;
  for (const auto& column : head.cell_columns) names.push_back(field_name(column.name, taken));
  return names;
}

// Quotes a name for the header.
std::string quoted(const std::string& name) {
  if (name.find_first_of("\",;") == std::string::npos) return name;
  std::string text = "\"";
  for (const char c : name) text += c == '"' ? std::string("\"\"") : std::string(1, c);
  return text + "\"";
}

// GDAL's integers have 64 bits and a sign.
bool is_real(AttributeType type) {
  return type == AttributeType::f32 || type == AttributeType::f64 || type == AttributeType::u64;
}

class CsvWriter : public StreamWriter {
 public:
  CsvWriter(OutputFile file, const MeshHead& head)
      : StreamWriter(std::move(file)), heights_(head.heights), cell_columns_(head.cell_columns) {
    stream_.text("geom");
    for (const char* field : first_fields) stream_.text(std::string(",") + field);
    for (const auto& field : cell_fields(head)) stream_.text("," + quoted(field));
    stream_.text("\n");
  }

  void vertex(const VertexView&) override {}
  void cell(const CellView& cell) override {
    stream_.text(heights_ ? "\"POLYGON Z ((" : "\"POLYGON ((");
    for (std::size_t k = 0; k < 4; ++k) {  // a ring ends where it began
      const Point& p = cell.at[k % 3];
      if (k > 0) stream_.text(",");
      stream_.digits(p.x);
      stream_.text(" ");
      stream_.digits(p.y);
      if (!heights_) continue;
      stream_.text(" ");
      stream_.digits(p.z);
    }
    stream_.text("))\",");
    stream_.digits(cell.tile.value);
    stream_.text(",");
    stream_.digits(cell.own);
    stream_.text(",1");
    for (std::size_t k = 0; k < 3; ++k) {
      stream_.text(",");
      stream_.digits(cell.ids[k].value);
    }
    for (std::size_t c = 0; c < cell_columns_.size(); ++c) {
      stream_.text(",");
      visit_value(cell_columns_[c].type, cell.values[c], [&](auto value) { number(value); });
    }
    stream_.text("\n");
  }

 private:
  // A number that is not finite is an empty field.
  template <class Value>
  void number(Value value) {
    if constexpr (std::is_floating_point_v<Value>) {
      if (std::isnan(value)) return;
    }
    // Readers use doubles, and the shortest digits of a float would give another double.
    if constexpr (std::is_same_v<Value, float>) return stream_.digits(static_cast<double>(value));
    stream_.digits(value);
  }

  bool heights_;
  std::vector<Attribute> cell_columns_;
};

std::string layer(const MeshHead& head, const std::string& file) {
  const std::string name = file.substr(0, file.rfind('.'));
  std::string text = "<OGRVRTLayer name=\"" + xml_text(name) + "\">\n<SrcDataSource relativeToVRT=\"1\">" +
                     xml_text(file) + "</SrcDataSource>\n<SrcLayer>" + xml_text(name) + "</SrcLayer>\n<GeometryType>" +
                     (head.heights ? "wkbPolygon25D" : "wkbPolygon") + "</GeometryType>\n<LayerSRS>" +
                     xml_text(head.crs.empty() ? undefined_crs : head.crs) +
                     "</LayerSRS>\n<GeometryField encoding=\"WKT\" field=\"geom\"/>\n";
  const auto field = [&](const std::string& named, const char* type) {
    text += "<Field name=\"" + xml_text(named) + "\" type=\"" + type + "\"/>\n";
  };
  for (const char* name_of : first_fields) field(name_of, *name_of == 'v' ? "Integer64" : "Integer");
  const auto fields = cell_fields(head);
  for (std::size_t c = 0; c < fields.size(); ++c)
    field(fields[c], is_real(head.cell_columns[c].type) ? "Real" : "Integer64");
  return text + "</OGRVRTLayer>\n";
}

}  // namespace

OpenedWriter open_csv(const std::filesystem::path& path, const MeshHead& head) {
  BOOST_OUTCOME_TRY(file, OutputFile::create(path));
  return std::make_unique<CsvWriter>(std::move(file), head);
}

std::string vrt_index(const MeshHead& head, const std::vector<std::string>& files) {
  std::string layers;
  for (const auto& file : files) layers += layer(head, file);
  if (files.size() > 1) layers = "<OGRVRTUnionLayer name=\"triangulation\">\n" + layers + "</OGRVRTUnionLayer>\n";
  // A file name can be any bytes, and must keep these bytes to be found. As Latin-1 they are valid XML, too. GDAL takes
  // the bytes as they are, whatever encoding is declared.
  const bool utf8 = std::all_of(files.begin(), files.end(), [](const auto& file) { return is_utf8(file); });
  const std::string declaration = utf8 ? "" : "<?xml version=\"1.0\" encoding=\"ISO-8859-1\"?>\n";
  return declaration + "<OGRVRTDataSource>\n" + layers + "</OGRVRTDataSource>\n";
}

}  // namespace tessera::exports
