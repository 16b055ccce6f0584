// CSV with the triangles as WKT polygons, and OGR's VRT that makes layers of such tables: what the QGIS projects of the
// paper's authors are made of (columns geom, tid: the tile, local: how many vertices are the tile's own, main). GDAL is
// not needed to write it.
#include <algorithm>

#include "src/base/utf8.h"
#include "src/crs/crs.h"
#include "src/export/formats.h"
#include "src/export/stream_writer.h"

namespace tessera::exports {

namespace {

class CsvWriter : public StreamWriter {
 public:
  CsvWriter(OutputFile file, const MeshHead& head) : StreamWriter(std::move(file)), heights_(head.heights) {
    stream_.text("geom,tid,local,main,v0,v1,v2\n");
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
    stream_.text("\n");
  }

 private:
  bool heights_;
};

std::string layer(const MeshHead& head, const std::string& file) {
  const std::string name = file.substr(0, file.rfind('.'));
  std::string text = "<OGRVRTLayer name=\"" + xml_text(name) + "\">\n<SrcDataSource relativeToVRT=\"1\">" +
                     xml_text(file) + "</SrcDataSource>\n<SrcLayer>" + xml_text(name) + "</SrcLayer>\n<GeometryType>" +
                     (head.heights ? "wkbPolygon25D" : "wkbPolygon") + "</GeometryType>\n<LayerSRS>" +
                     xml_text(head.crs.empty() ? undefined_crs : head.crs) +
                     "</LayerSRS>\n<GeometryField encoding=\"WKT\" field=\"geom\"/>\n";
  for (const char* field : {"tid", "local", "main"})
    text += std::string("<Field name=\"") + field + "\" type=\"Integer\"/>\n";
  for (const char* field : {"v0", "v1", "v2"})
    text += std::string("<Field name=\"") + field + "\" type=\"Integer64\"/>\n";
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
  // A name of a file can be any bytes, and must stay those to be found. As Latin-1 they are XML, too; GDAL takes bytes
  // as they are, whatever is declared.
  const bool utf8 = std::all_of(files.begin(), files.end(), [](const auto& file) { return is_utf8(file); });
  const std::string declaration = utf8 ? "" : "<?xml version=\"1.0\" encoding=\"ISO-8859-1\"?>\n";
  return declaration + "<OGRVRTDataSource>\n" + layers + "</OGRVRTDataSource>\n";
}

}  // namespace tessera::exports
