// VTK's XML format with raw appended data. Every array has its place in the file from the start, since all counts are
// in the manifest; the tiles then fill the arrays side by side.
#include <algorithm>
#include <string>

#include "src/store/export_common.h"
#include "src/store/tile_layout.h"

namespace tessera::store {

namespace fs = std::filesystem;

namespace {

const char* vtk_type(AttributeType type) {
  constexpr const char* names[] = {"UInt8", "Int8",   "UInt16", "Int16",   "UInt32",
                                   "Int32", "UInt64", "Int64",  "Float32", "Float64"};
  return names[static_cast<int>(type)];
}

std::string xml_text(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '&') {
      result += "&amp;";
    } else if (c == '<') {
      result += "&lt;";
    } else if (c == '"') {
      result += "&quot;";
    } else {
      result += c;
    }
  }
  return result;
}

struct VtuArray {
  std::string name;
  AttributeType type;
  int components;
  std::uint64_t bytes;
};

constexpr const char* xml_start = "<?xml version=\"1.0\"?>\n<VTKFile type=\"";
constexpr const char* xml_version = "\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n";

// One .vtu: a stream for every array.
class VtuFile {
 public:
  static Result<VtuFile> create(const fs::path& target, const std::vector<Attribute>& schema, std::uint64_t points,
                                std::uint64_t cells, int dimension) {
    BOOST_OUTCOME_TRY(file, OutputFile::create(target));
    return VtuFile(std::move(file), schema, points, cells, dimension);
  }

  void point(const Point& p, std::uint64_t id, const std::byte* row) {
    streams_[0].value(p);
    streams_[4].value(id);
    for (std::size_t a = 0; a < sizes_.size(); row += sizes_[a], ++a) streams_[5 + a].bytes({row, sizes_[a]});
  }
  void cell(std::span<const std::uint64_t> numbers) {
    for (const auto number : numbers) streams_[1].value(static_cast<std::int64_t>(number));
    connectivity_ += static_cast<std::int64_t>(numbers.size());
    streams_[2].value(connectivity_);
    streams_[3].value(vtk_cell_type(static_cast<int>(numbers.size()) - 1));
  }
  Result<std::uint64_t> finish() {
    Stream tail(file_, end_);
    tail.text("\n</AppendedData>\n</VTKFile>\n");
    BOOST_OUTCOME_TRYV(tail.flush());
    for (auto& stream : streams_) {
      BOOST_OUTCOME_TRYV(stream.flush());
    }
    return file_.finish();
  }

 private:
  VtuFile(OutputFile file, const std::vector<Attribute>& schema, std::uint64_t points, std::uint64_t cells,
          int dimension)
      : file_(std::move(file)) {
    const auto corners = static_cast<std::uint64_t>(dimension + 1);
    std::vector<VtuArray> arrays{{"Points", AttributeType::f64, 3, points * 24},
                                 {"connectivity", AttributeType::i64, 1, cells * corners * 8},
                                 {"offsets", AttributeType::i64, 1, cells * 8},
                                 {"types", AttributeType::u8, 1, cells},
                                 {"id", AttributeType::u64, 1, points * 8}};
    for (const auto& attribute : schema) {
      sizes_.push_back(size_of(attribute.type));
      arrays.push_back({attribute.name, attribute.type, 1, points * sizes_.back()});
    }
    std::uint64_t offset = 0;
    std::vector<std::string> declarations;
    for (const auto& array : arrays) {
      declarations.push_back("<DataArray type=\"" + std::string(vtk_type(array.type)) + "\" Name=\"" +
                             xml_text(array.name) + "\" NumberOfComponents=\"" + std::to_string(array.components) +
                             "\" format=\"appended\" offset=\"" + std::to_string(offset) + "\"/>\n");
      offset += 8 + array.bytes;
    }
    std::string header =
        xml_start + std::string("UnstructuredGrid") + xml_version + "<UnstructuredGrid>\n<Piece NumberOfPoints=\"" +
        std::to_string(points) + "\" NumberOfCells=\"" + std::to_string(cells) + "\">\n<Points>\n" + declarations[0] +
        "</Points>\n<Cells>\n" + declarations[1] + declarations[2] + declarations[3] + "</Cells>\n<PointData>\n";
    for (std::size_t i = 4; i < declarations.size(); ++i) header += declarations[i];
    header += "</PointData>\n</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_";

    std::uint64_t at = 0;
    for (std::size_t i = 0; i < arrays.size(); ++i) {
      streams_.emplace_back(file_, at);
      if (i == 0) streams_[0].text(header);
      streams_[i].value(arrays[i].bytes);
      at = streams_[i].offset() + arrays[i].bytes;
    }
    end_ = at;
  }

  OutputFile file_;
  std::vector<Stream> streams_;
  std::vector<std::size_t> sizes_;
  std::int64_t connectivity_ = 0;
  std::uint64_t end_ = 0;
};

Status check_schema(const fs::path& out, const Manifest& manifest, const StoredTile& tile) {
  if (tile.schema == manifest.schema) return success();
  return error(Errc::corrupt, out.string() + ": a tile has other attributes than the manifest");
}

// Main cells of one tile with the vertices they use.
Result<std::uint64_t> write_piece(const fs::path& target, const Manifest& manifest, const StoredTile& tile) {
  const TileMesh& mesh = tile.mesh;
  const std::size_t corners = static_cast<std::size_t>(manifest.dimension) + 1;
  constexpr std::uint64_t unused = ~std::uint64_t{0};
  std::vector<std::uint64_t> number(mesh.points.size(), unused);
  std::uint64_t cells = 0, points = 0;
  for (std::size_t i = 0; i < mesh.cell_ghost.size(); ++i) {
    if (mesh.cell_ghost[i] != 0) continue;
    ++cells;
    for (std::size_t k = 0; k < corners; ++k) number[static_cast<std::size_t>(mesh.cells[i * corners + k])] = 0;
  }
  for (auto& n : number)
    if (n != unused) n = points++;
  BOOST_OUTCOME_TRY(file, VtuFile::create(target, manifest.schema, points, cells, manifest.dimension));
  const std::size_t stride = row_bytes(manifest.schema);
  for (std::size_t i = 0; i < number.size(); ++i)
    if (number[i] != unused) file.point(mesh.points[i], mesh.ids[i], tile.rows.data() + i * stride);
  std::uint64_t cell[4];
  for (std::size_t i = 0; i < mesh.cell_ghost.size(); ++i) {
    if (mesh.cell_ghost[i] != 0) continue;
    for (std::size_t k = 0; k < corners; ++k) cell[k] = number[static_cast<std::size_t>(mesh.cells[i * corners + k])];
    file.cell({cell, corners});
  }
  return file.finish();
}

// Files of a folder that is only whole with all of them: removed again unless kept.
struct WrittenPieces {
  std::vector<fs::path> paths;  // in the order of writing; a folder before what is in it
  ~WrittenPieces() {
    std::error_code code;
    for (auto path = paths.rbegin(); path != paths.rend(); ++path) fs::remove(*path, code);
  }
};

}  // namespace

Result<Exported> export_vtu_file(const fs::path& out, const Manifest& manifest, const fs::path& target,
                                 std::stop_token stop) {
  BOOST_OUTCOME_TRY(file,
                    VtuFile::create(target, manifest.schema, manifest.vertices, manifest.cells, manifest.dimension));
  const std::size_t stride = row_bytes(manifest.schema);
  Exported exported;
  BOOST_OUTCOME_TRY(numbers, VertexNumbers::assign(out, manifest, true, stop, [&](const StoredTile& tile) -> Status {
                      BOOST_OUTCOME_TRYV(check_schema(out, manifest, tile));
                      for (std::size_t i = 0; i < tile.mesh.points.size(); ++i) {
                        if (tile.mesh.point_ghost[i] != 0) continue;
                        // More than announced would run into the next array.
                        if (++exported.vertices > manifest.vertices) return check_counts(out, manifest, exported);
                        file.point(tile.mesh.points[i], tile.mesh.ids[i], tile.rows.data() + i * stride);
                      }
                      return success();
                    }));
  const std::size_t corners = static_cast<std::size_t>(manifest.dimension) + 1;
  const auto write_cells = [&](const StoredTile& tile, std::size_t index) -> Status {
    BOOST_OUTCOME_TRY(of, numbers.of(tile.mesh, index, tile_file(out, TileId{manifest.tiles[index].tile})));
    std::uint64_t cell[4];
    for (std::size_t i = 0; i < tile.mesh.cell_ghost.size(); ++i) {
      if (tile.mesh.cell_ghost[i] != 0) continue;
      if (++exported.cells > manifest.cells) return check_counts(out, manifest, exported);
      for (std::size_t k = 0; k < corners; ++k)
        cell[k] = of[static_cast<std::size_t>(tile.mesh.cells[i * corners + k])];
      file.cell({cell, corners});
    }
    return success();
  };
  BOOST_OUTCOME_TRYV(for_each_tile(out, manifest, false, stop, write_cells));
  BOOST_OUTCOME_TRYV(check_counts(out, manifest, exported));
  BOOST_OUTCOME_TRY(bytes, file.finish());
  exported.bytes = bytes;
  return exported;
}

Result<Exported> export_vtu_folder(const fs::path& out, const Manifest& manifest, const fs::path& target,
                                   std::stop_token stop) {
  Exported exported;
  WrittenPieces written;
  std::error_code code;
  if (!fs::exists(target, code)) written.paths.push_back(target);
  BOOST_OUTCOME_TRYV(make_directories(target));
  std::string pieces;
  const auto write_tile = [&](const StoredTile& tile, std::size_t index) -> Status {
    BOOST_OUTCOME_TRYV(check_schema(out, manifest, tile));
    const auto name = tile_file("", TileId{manifest.tiles[index].tile}).filename().replace_extension(".vtu");
    BOOST_OUTCOME_TRY(bytes, write_piece(target / name, manifest, tile));
    written.paths.push_back(target / name);
    pieces += "<Piece Source=\"" + name.string() + "\"/>\n";
    exported.bytes += bytes;
    const auto count = [](const auto& ghosts) {
      return static_cast<std::uint64_t>(std::count(ghosts.begin(), ghosts.end(), 0));
    };
    exported.vertices += count(tile.mesh.point_ghost);
    exported.cells += count(tile.mesh.cell_ghost);
    return success();
  };
  BOOST_OUTCOME_TRYV(for_each_tile(out, manifest, true, stop, write_tile));
  BOOST_OUTCOME_TRYV(check_counts(out, manifest, exported));

  std::string text =
      xml_start + std::string("PUnstructuredGrid") + xml_version +
      "<PUnstructuredGrid GhostLevel=\"0\">\n<PPoints>\n<PDataArray type=\"Float64\" Name=\"Points\" "
      "NumberOfComponents=\"3\"/>\n</PPoints>\n<PPointData>\n<PDataArray type=\"UInt64\" Name=\"id\"/>\n";
  for (const auto& attribute : manifest.schema)
    text += std::string("<PDataArray type=\"") + vtk_type(attribute.type) + "\" Name=\"" + xml_text(attribute.name) +
            "\"/>\n";
  text += "</PPointData>\n" + pieces + "</PUnstructuredGrid>\n</VTKFile>\n";
  BOOST_OUTCOME_TRYV(write_whole(target / "triangulation.pvtu", text));
  exported.bytes += text.size();
  written.paths.clear();
  return exported;
}

}  // namespace tessera::store
