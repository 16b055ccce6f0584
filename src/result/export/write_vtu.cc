// VTK's XML format with raw appended data. All counts are known, so every array has its place in the file from the
// start. Points and cells fill the arrays side by side.
#include <string>

#include "src/result/export/formats.h"
#include "src/result/export/output.h"
#include "src/result/store/tile_layout.h"

namespace tessera::exports {

namespace {

const char* vtk_type(AttributeType type) {
  constexpr const char* names[] = {"UInt8", "Int8",   "UInt16", "Int16",   "UInt32",
                                   "Int32", "UInt64", "Int64",  "Float32", "Float64"};
  return names[static_cast<int>(type)];
}

struct VtuArray {
  std::string name;
  AttributeType type;
  int components;
  std::uint64_t bytes;
};

constexpr const char* xml_start = "<?xml version=\"1.0\"?>\n<VTKFile type=\"";
constexpr const char* xml_version = "\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n";

// A comment, and no field data: readers such as meshio refuse arrays of text.
std::string xml_comment(const MeshHead& head) { return head.stamp ? "<!-- " + comment_of(*head.stamp) + " -->\n" : ""; }

// Writes one stream for each array.
class VtuWriter : public MeshWriter {
 public:
  VtuWriter(OutputFile file, const MeshHead& head)
      : file_(std::move(file)),
        columns_(head.columns),
        cell_columns_(head.cell_columns),
        corners_(head.corners()),
        cell_type_(store::vtk_cell_type(head.dimension)),
        final_(head.final) {
    std::vector<VtuArray> arrays{{"Points", AttributeType::f64, 3, head.vertices * 24},
                                 {"connectivity", AttributeType::i64, 1, head.cells * corners_ * 8},
                                 {"offsets", AttributeType::i64, 1, head.cells * 8},
                                 {"types", AttributeType::u8, 1, head.cells},
                                 {"tile", AttributeType::u32, 1, head.cells * 4},
                                 {"longest_edge", AttributeType::f64, 1, head.cells * 8},
                                 {"id", AttributeType::u64, 1, head.vertices * 8}};
    for (const auto& column : columns_)
      arrays.push_back({column.name, column.type, column.components, head.vertices * column.bytes()});
    for (const auto& column : cell_columns_)
      arrays.push_back({column.name, column.type, 1, head.cells * size_of(column.type)});
    if (head.final) arrays.push_back({"final", AttributeType::u8, 1, head.cells});
    const std::string text = header(head, arrays);
    std::uint64_t at = 0;
    for (std::size_t i = 0; i < arrays.size(); ++i) {
      streams_.emplace_back(file_, at);
      if (i == 0) streams_[0].text(text);
      streams_[i].value(arrays[i].bytes);
      at = streams_[i].offset() + arrays[i].bytes;
    }
    end_ = at;
  }

  void vertex(const VertexView& vertex) override {
    streams_[0].value(vertex.at);
    streams_[6].value(vertex.id);
    for (std::size_t c = 0; c < columns_.size(); ++c)
      streams_[7 + c].bytes({vertex.row + columns_[c].offset, columns_[c].bytes()});
  }
  void cell(const CellView& cell) override {
    for (std::size_t k = 0; k < corners_; ++k) streams_[1].value(static_cast<std::int64_t>(cell.numbers[k]));
    connectivity_ += static_cast<std::int64_t>(corners_);
    streams_[2].value(connectivity_);
    streams_[3].value(cell_type_);
    streams_[4].value(cell.tile);
    streams_[5].value(cell.longest_edge);
    for (std::size_t c = 0; c < cell_columns_.size(); ++c)
      streams_[7 + columns_.size() + c].bytes({cell.values[c], size_of(cell_columns_[c].type)});
    if (final_) streams_.back().value(static_cast<std::uint8_t>(cell.final));
  }
  Status check() override {
    for (const auto& stream : streams_) {
      BOOST_OUTCOME_TRYV(stream.status());
    }
    return success();
  }
  Result<std::uint64_t> finish() override {
    for (auto& stream : streams_) {
      BOOST_OUTCOME_TRYV(stream.flush());
    }
    Stream tail(file_, end_);
    tail.text("\n</AppendedData>\n</VTKFile>\n");
    BOOST_OUTCOME_TRYV(tail.flush());
    return file_.finish();
  }

 private:
  static std::string header(const MeshHead& head, const std::vector<VtuArray>& arrays) {
    std::uint64_t offset = 0;
    std::vector<std::string> declarations;
    for (const auto& array : arrays) {
      declarations.push_back("<DataArray type=\"" + std::string(vtk_type(array.type)) + "\" Name=\"" +
                             xml_text(array.name) + "\" NumberOfComponents=\"" + std::to_string(array.components) +
                             "\" format=\"appended\" offset=\"" + std::to_string(offset) + "\"/>\n");
      offset += 8 + array.bytes;
    }
    std::string text = xml_start + std::string("UnstructuredGrid") + xml_version + xml_comment(head) +
                       "<UnstructuredGrid>\n<Piece NumberOfPoints=\"" + std::to_string(head.vertices) +
                       "\" NumberOfCells=\"" + std::to_string(head.cells) + "\">\n<Points>\n" + declarations[0] +
                       "</Points>\n<Cells>\n" + declarations[1] + declarations[2] + declarations[3] +
                       "</Cells>\n<CellData>\n" + declarations[4] + declarations[5] +
                       (head.final ? declarations.back() : "");
    const std::size_t vertices_end = 7 + head.columns.size();
    for (std::size_t i = 0; i < head.cell_columns.size(); ++i) text += declarations[vertices_end + i];
    text += "</CellData>\n<PointData>\n";
    for (std::size_t i = 6; i < vertices_end; ++i) text += declarations[i];
    return text + "</PointData>\n</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_";
  }

  OutputFile file_;
  std::vector<Stream> streams_;
  std::vector<Column> columns_;
  std::vector<Attribute> cell_columns_;
  std::size_t corners_;
  std::uint8_t cell_type_;
  bool final_;
  std::int64_t connectivity_ = 0;
  std::uint64_t end_ = 0;
};

}  // namespace

OpenedWriter open_vtu(const std::filesystem::path& path, const MeshHead& head) {
  BOOST_OUTCOME_TRY(file, OutputFile::create(path));
  return std::make_unique<VtuWriter>(std::move(file), head);
}

std::string pvtu_index(const MeshHead& head, const std::vector<std::string>& files) {
  std::string text =
      xml_start + std::string("PUnstructuredGrid") + xml_version + xml_comment(head) +
      "<PUnstructuredGrid GhostLevel=\"0\">\n<PPoints>\n<PDataArray type=\"Float64\" Name=\"Points\" "
      "NumberOfComponents=\"3\"/>\n</PPoints>\n<PPointData>\n<PDataArray type=\"UInt64\" Name=\"id\"/>\n";
  for (const auto& column : head.columns)
    text += std::string("<PDataArray type=\"") + vtk_type(column.type) + "\" Name=\"" + xml_text(column.name) +
            (column.components > 1 ? "\" NumberOfComponents=\"" + std::to_string(column.components) : "") + "\"/>\n";
  text +=
      "</PPointData>\n<PCellData>\n<PDataArray type=\"UInt32\" Name=\"tile\"/>\n"
      "<PDataArray type=\"Float64\" Name=\"longest_edge\"/>\n";
  if (head.final) text += "<PDataArray type=\"UInt8\" Name=\"final\"/>\n";
  for (const auto& column : head.cell_columns)
    text +=
        std::string("<PDataArray type=\"") + vtk_type(column.type) + "\" Name=\"" + xml_text(column.name) + "\"/>\n";
  text += "</PCellData>\n";
  for (const auto& file : files) text += "<Piece Source=\"" + xml_text(file) + "\"/>\n";
  return text + "</PUnstructuredGrid>\n</VTKFile>\n";
}

}  // namespace tessera::exports
