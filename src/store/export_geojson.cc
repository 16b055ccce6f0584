// GeoJSON: a FeatureCollection with one polygon a triangle. RFC 7946 knows longitude and latitude only; other systems
// are named by the "crs" member of the 2008 specification, which GDAL and QGIS read.
#include <algorithm>
#include <cctype>
#include <vector>

#include "src/store/export_common.h"

namespace tessera::store {

namespace fs = std::filesystem;

namespace {

bool is_number(const std::string& text) {
  return !text.empty() && text.size() < 10 &&
         std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isdigit(c) != 0; });
}

// The code of AUTHORITY["EPSG","2154"] or ID["EPSG",2154] standing at `at`; empty when it is none.
std::string authority_code(const std::string& wkt, std::size_t at) {
  std::string plain;
  for (std::size_t i = at; i < wkt.size() && wkt[i] != ']'; ++i)
    if (wkt[i] != '"' && wkt[i] != ' ') plain += wkt[i];
  for (const std::string start : {"AUTHORITY[EPSG,", "ID[EPSG,"})
    if (plain.starts_with(start) && is_number(plain.substr(start.size()))) return plain.substr(start.size());
  return {};
}

}  // namespace

std::string epsg_code(const std::string& crs) {
  if (crs.starts_with("EPSG:")) return is_number(crs.substr(5)) ? crs.substr(5) : std::string();
  // In a compound system the horizontal one is its first part, one level down.
  const bool compound = crs.starts_with("COMPD_CS") || crs.starts_with("COMPOUNDCRS");
  const int wanted = compound ? 2 : 1;
  int depth = 0, parts = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < crs.size(); ++i) {
    if (crs[i] == '"') quoted = !quoted;
    if (quoted) continue;
    if (crs[i] == '[') {
      ++depth;
      if (compound && depth == 2) ++parts;
    } else if (crs[i] == ']') {
      --depth;
    } else if (depth == wanted && (!compound || parts == 1) && (i == 0 || crs[i - 1] == ',' || crs[i - 1] == ' ')) {
      if (auto code = authority_code(crs, i); !code.empty()) return code;
    }
  }
  return {};
}

Result<Exported> export_geojson(const fs::path& out, const Manifest& manifest, const fs::path& target,
                                std::stop_token stop) {
  BOOST_OUTCOME_TRY(file, OutputFile::create(target));
  Stream stream(file, 0);
  stream.text("{\"type\":\"FeatureCollection\",");
  if (const auto code = epsg_code(manifest.crs); !code.empty())
    stream.text("\"crs\":{\"type\":\"name\",\"properties\":{\"name\":\"urn:ogc:def:crs:EPSG::" + code + "\"}},");
  stream.text("\"features\":[");
  Exported exported;
  const auto write_tile = [&](const StoredTile& tile, std::size_t index) -> Status {
    const TileMesh& mesh = tile.mesh;
    exported.vertices += static_cast<std::uint64_t>(std::count(mesh.point_ghost.begin(), mesh.point_ghost.end(), 0));
    for (std::size_t i = 0; i < mesh.cell_ghost.size(); ++i) {
      if (mesh.cell_ghost[i] != 0) continue;
      stream.text(exported.cells++ == 0 ? "\n" : ",\n");
      stream.text("{\"type\":\"Feature\",\"properties\":{\"tile\":");
      stream.digits(manifest.tiles[index].tile);
      stream.text(",\"vertices\":[");
      for (std::size_t k = 0; k < 3; ++k) {
        if (k > 0) stream.text(",");
        stream.digits(mesh.ids[static_cast<std::size_t>(mesh.cells[3 * i + k])]);
      }
      stream.text("]},\"geometry\":{\"type\":\"Polygon\",\"coordinates\":[[");
      for (std::size_t k = 0; k < 4; ++k) {  // a ring ends where it began
        const Point& p = mesh.points[static_cast<std::size_t>(mesh.cells[3 * i + k % 3])];
        stream.text(k == 0 ? "[" : ",[");
        stream.digits(p.x);
        stream.text(",");
        stream.digits(p.y);
        stream.text("]");
      }
      stream.text("]]}}");
    }
    return success();
  };
  BOOST_OUTCOME_TRYV(for_each_tile(out, manifest, false, stop, write_tile));
  stream.text("\n]}\n");
  BOOST_OUTCOME_TRYV(stream.flush());
  BOOST_OUTCOME_TRYV(check_counts(out, manifest, exported));
  BOOST_OUTCOME_TRY(bytes, file.finish());
  exported.bytes = bytes;
  return exported;
}

}  // namespace tessera::store
