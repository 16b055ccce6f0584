#include "src/result/store/vtk_xml.h"

#include <algorithm>
#include <array>
#include <charconv>

#include "src/base/files/names.h"

namespace tessera::store {

namespace {

// In the order of AttributeType and of Section.
constexpr std::array<std::string_view, 10> type_names{"UInt8", "Int8",   "UInt16", "Int16",   "UInt32",
                                                      "Int32", "UInt64", "Int64",  "Float32", "Float64"};
constexpr std::array<std::string_view, 4> section_names{"Points", "PointData", "Cells", "CellData"};

constexpr std::string_view format_words = "<?xml version=\"1.0\"?>\n<!-- Tessera, format ";

std::string escaped(std::string_view name) {
  std::string result;
  for (const char c : name) {
    switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      default:
        result += c;
    }
  }
  return result;
}

// The inverse of escaped(). Other references stay as they are; then header_text() did not make the text.
std::string unescaped(std::string_view text) {
  constexpr std::array<std::pair<std::string_view, char>, 4> references{
      {{"&amp;", '&'}, {"&lt;", '<'}, {"&gt;", '>'}, {"&quot;", '"'}}};
  std::string result;
  while (!text.empty()) {
    const auto found = std::find_if(references.begin(), references.end(),
                                    [&](const auto& reference) { return text.starts_with(reference.first); });
    result += found == references.end() ? text.front() : found->second;
    text.remove_prefix(found == references.end() ? 1 : found->first.size());
  }
  return result;
}

std::string array_start(std::string_view element, const ArrayInfo& array) {
  return "<" + std::string(element) + " type=\"" + std::string(type_names[static_cast<std::size_t>(array.type)]) +
         "\" Name=\"" + escaped(array.name) + "\" NumberOfComponents=\"" + std::to_string(array.columns) + "\"";
}

// Reads a text with known words, from front to back.
class Scanner {
 public:
  explicit Scanner(std::string_view text) : text_(text) {}
  bool skip(std::string_view expected) {
    if (!text_.starts_with(expected)) return false;
    text_.remove_prefix(expected.size());
    return true;
  }
  template <class Integer>
  bool number(Integer& value) {
    const auto [end, code] = std::from_chars(text_.data(), text_.data() + text_.size(), value);
    if (code != std::errc()) return false;
    text_.remove_prefix(static_cast<std::size_t>(end - text_.data()));
    return true;
  }
  // Reads up to the next `end`, and skips it.
  bool until(char end, std::string_view& value) {
    const auto at = text_.find(end);
    if (at == std::string_view::npos) return false;
    value = text_.substr(0, at);
    text_.remove_prefix(at + 1);
    return true;
  }

 private:
  std::string_view text_;
};

}  // namespace

std::uint64_t TileHeader::bytes_of(const ArrayInfo& array) const {
  const std::uint64_t rows = array.rows == ArrayOf::points  ? points
                             : array.rows == ArrayOf::cells ? cells
                                                            : cells * static_cast<std::uint64_t>(dimension + 1);
  return rows * array.columns * size_of(array.type);
}

std::string header_text(const TileHeader& header, std::size_t size) {
  std::string text = std::string(format_words) + std::to_string(header.format) + ", dimension " +
                     std::to_string(header.dimension) + ", tile " + std::to_string(header.tile.value) +
                     " -->\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
                     "header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\">\n<UnstructuredGrid>\n"
                     "<Piece NumberOfPoints=\"" +
                     std::to_string(header.points) + "\" NumberOfCells=\"" + std::to_string(header.cells) + "\">\n";
  const auto arrays = header.arrays();
  std::size_t next = 0;
  for (std::size_t section = 0; section < section_names.size(); ++section) {
    text += "<" + std::string(section_names[section]) + ">\n";
    for (; next < arrays.size() && arrays[next].section == static_cast<Section>(section); ++next)
      text += array_start("DataArray", arrays[next]) + " format=\"appended\" offset=\"" +
              std::to_string(header.offsets[next]) + "\"/>\n";
    text += "</" + std::string(section_names[section]) + ">\n";
  }
  text += "</Piece>\n</UnstructuredGrid>\n";
  text.resize(std::max(text.size() + header_end.size(), size) - header_end.size(), ' ');
  return text += header_end;
}

std::optional<TileHeader> parse_header(std::string_view text) {
  TileHeader header;
  Scanner in(text);
  std::string_view word;
  if (!in.skip(format_words) || !in.number(header.format) || !in.skip(", dimension ") || !in.number(header.dimension) ||
      !in.skip(", tile ") || !in.number(header.tile.value) || !in.skip(" -->\n") || !in.until('\n', word) ||
      !in.skip("<UnstructuredGrid>\n<Piece NumberOfPoints=\"") || !in.number(header.points) ||
      !in.skip("\" NumberOfCells=\"") || !in.number(header.cells) || !in.skip("\">\n"))
    return std::nullopt;
  if (header.dimension != 2 && header.dimension != 3) return std::nullopt;
  if (header.format < 2 || header.format > changed_format) return std::nullopt;
  header.neighbors = false;
  bool point_data = false, cell_data = false;
  while (in.until('\n', word)) {
    if (word == "<PointData>") point_data = true;
    if (word == "</PointData>") point_data = false;
    if (word == "<CellData>") cell_data = true;
    Scanner line(word);
    std::string_view type, name, columns;
    std::uint64_t offset = 0;
    if (!line.skip("<DataArray type=\"") || !line.until('"', type) || !line.skip(" Name=\"") ||
        !line.until('"', name) || !line.skip(" NumberOfComponents=\"") || !line.until('"', columns) ||
        !line.skip(" format=\"appended\" offset=\"") || !line.number(offset))
      continue;
    header.offsets.push_back(offset);
    const auto found = std::find(type_names.begin(), type_names.end(), type);
    if (found == type_names.end()) return std::nullopt;
    if (point_data && name == images_array) {
      header.images = true;
    } else if (point_data && header.offsets.size() > first_attribute) {
      header.schema.push_back({unescaped(name), static_cast<AttributeType>(found - type_names.begin())});
    }
    if (cell_data && name == "final") {
      header.final = true;
    } else if (cell_data && name == "neighbors") {
      header.neighbors = true;
    } else if (cell_data && name != "vtkGhostType" && name != "tile") {
      header.cell_schema.push_back({unescaped(name), static_cast<AttributeType>(found - type_names.begin())});
    }
  }
  // Comparing with the schema as it would be stored finds what was not checked above.
  const auto schema = stored_schema(header.schema);
  const auto cell_schema = stored_cell_schema(header.cell_schema);
  if (!schema || schema.value() != header.schema) return std::nullopt;
  if (!cell_schema || cell_schema.value() != header.cell_schema) return std::nullopt;
  if (header.format < changed_format && !header.cell_schema.empty()) return std::nullopt;
  if (header.offsets.size() != header.arrays().size() ||
      header_text(header, header.format < 3 ? 0 : text.size()) != text)
    return std::nullopt;
  return header;
}

std::string master_text(const Manifest& manifest) {
  std::string text = std::string(format_words) + std::to_string(manifest.format_version) +
                     " -->\n<VTKFile type=\"PUnstructuredGrid\" version=\"1.0\" "
                     "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<PUnstructuredGrid GhostLevel=\"0\">\n";
  // Neighbours are left out: they are indices into one tile, so they are of no use here, and they are as large as the
  // cells. So are the offsets of images, which not every tile has.
  const auto arrays = tile_arrays(manifest.dimension, manifest.region && !manifest.region->complete, false,
                                  manifest.schema, cell_schema_of(manifest));
  for (const Section section : {Section::points, Section::point_data, Section::cell_data}) {
    const std::string element = "P" + std::string(section_names[static_cast<std::size_t>(section)]);
    text += "<" + element + ">\n";
    for (const auto& array : arrays)
      if (array.section == section) text += array_start("PDataArray", array) + "/>\n";
    text += "</" + element + ">\n";
  }
  for (const auto& entry : manifest.tiles)
    if (entry.kind == TileKind::cells) text += "<Piece Source=\"" + tile_file("", entry).generic_string() + "\"/>\n";
  return text + "</PUnstructuredGrid>\n</VTKFile>\n";
}

}  // namespace tessera::store
