// Text formats with the same structure: a head, one line a vertex, a line between, one line a cell, an end. Coordinates
// have the shortest digits that are read back as the same double.
//  OFF            3D: each tetrahedron as its list of vertices
//  OBJ            2D only; numbers from 1
//  MEDIT .mesh    version 2 (double precision). Always three coordinates: Gmsh reads no other. Reference 1 for all.
#include <string_view>

#include "src/result/export/formats.h"
#include "src/result/export/stream_writer.h"

namespace tessera::exports {

namespace {

struct Syntax {
  std::string before_vertices;
  std::string_view vertex_start, vertex_end;
  std::string before_cells;
  std::string_view cell_start, cell_end;
  std::uint64_t first_number = 1;  // of vertices
  std::string_view end;
};

class TextMeshWriter : public StreamWriter {
 public:
  TextMeshWriter(OutputFile file, const MeshHead& head, Syntax syntax)
      : StreamWriter(std::move(file)), syntax_(std::move(syntax)), corners_(head.corners()) {
    stream_.text(syntax_.before_vertices);
  }

  void vertex(const VertexView& vertex) override {
    stream_.text(syntax_.vertex_start);
    for (int axis = 0; axis < 3; ++axis) {
      if (axis > 0) stream_.text(" ");
      stream_.digits(vertex.at[axis]);
    }
    stream_.text(syntax_.vertex_end);
  }
  void cell(const CellView& cell) override {
    if (!any_cells_) stream_.text(syntax_.before_cells);
    any_cells_ = true;
    stream_.text(syntax_.cell_start);
    for (std::size_t k = 0; k < corners_; ++k) {
      if (k > 0) stream_.text(" ");
      stream_.digits(cell.numbers[k] + syntax_.first_number);
    }
    stream_.text(syntax_.cell_end);
  }

 private:
  void end() override {
    if (!any_cells_) stream_.text(syntax_.before_cells);
    stream_.text(syntax_.end);
  }
  Syntax syntax_;
  std::size_t corners_;
  bool any_cells_ = false;
};

std::string comments(const MeshHead& head) {
  return (head.stamp ? "# " + comment_of(*head.stamp) + "\n" : "") +
         (head.corner ? "# " + head.corner_comment() + "\n" : "");
}

OpenedWriter open_text(const std::filesystem::path& path, const MeshHead& head, Syntax syntax) {
  BOOST_OUTCOME_TRY(file, OutputFile::create(path));
  return std::make_unique<TextMeshWriter>(std::move(file), head, std::move(syntax));
}

}  // namespace

OpenedWriter open_off(const std::filesystem::path& path, const MeshHead& head) {
  return open_text(path, head,
                   {.before_vertices = "OFF\n" + comments(head) + std::to_string(head.vertices) + " " +
                                       std::to_string(head.cells) + " 0\n",
                    .vertex_start = "",
                    .vertex_end = "\n",
                    .before_cells = "",
                    .cell_start = head.dimension == 2 ? "3 " : "4 ",
                    .cell_end = "\n",
                    .first_number = 0,
                    .end = ""});
}

OpenedWriter open_obj(const std::filesystem::path& path, const MeshHead& head) {
  return open_text(path, head,
                   {.before_vertices = "# tessera " + head.software_version + "\n" + comments(head),
                    .vertex_start = "v ",
                    .vertex_end = "\n",
                    .before_cells = "",
                    .cell_start = "f ",
                    .cell_end = "\n",
                    .end = ""});
}

OpenedWriter open_medit(const std::filesystem::path& path, const MeshHead& head) {
  const std::string kind = head.dimension == 2 ? "Triangles" : "Tetrahedra";
  return open_text(
      path, head,
      {.before_vertices = "MeshVersionFormatted 2\nDimension 3\nVertices\n" + std::to_string(head.vertices) + "\n",
       .vertex_start = "",
       .vertex_end = " 1\n",
       .before_cells = kind + "\n" + std::to_string(head.cells) + "\n",
       .cell_start = "",
       .cell_end = " 1\n",
       .end = "End\n"});
}

}  // namespace tessera::exports
