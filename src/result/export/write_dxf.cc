// DXF as AutoCAD R12 wrote it, which every program reads: one 3DFACE a triangle, all on the layer TIN, so that
// surveyors choose one layer to make a surface of. The format has no coordinate system.
#include <array>
#include <charconv>
#include <string_view>

#include "src/result/export/formats.h"
#include "src/result/export/stream_writer.h"

namespace tessera::exports {

namespace {

constexpr std::string_view head_text =
    "0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1009\n0\nENDSEC\n"
    "0\nSECTION\n2\nTABLES\n"
    "0\nTABLE\n2\nLTYPE\n70\n1\n0\nLTYPE\n2\nCONTINUOUS\n70\n0\n3\nSolid line\n72\n65\n73\n0\n40\n0.0\n0\nENDTAB\n"
    "0\nTABLE\n2\nLAYER\n70\n2\n0\nLAYER\n2\n0\n70\n0\n62\n7\n6\nCONTINUOUS\n"
    "0\nLAYER\n2\nTIN\n70\n0\n62\n7\n6\nCONTINUOUS\n0\nENDTAB\n0\nENDSEC\n"
    "0\nSECTION\n2\nENTITIES\n";

class DxfWriter : public StreamWriter {
 public:
  explicit DxfWriter(OutputFile file) : StreamWriter(std::move(file)) { stream_.text(head_text); }
  void vertex(const VertexView&) override {}
  void cell(const CellView& cell) override {
    stream_.text("0\n3DFACE\n8\nTIN\n");
    for (std::size_t k = 0; k < 4; ++k) {  // a triangle has its third corner twice
      const Point& at = cell.at[k < 2 ? k : 2];
      for (int axis = 0; axis < 3; ++axis) {
        stream_.digits(10 * (axis + 1) + static_cast<int>(k));
        stream_.text("\n");
        real(at[axis]);
      }
    }
  }

 private:
  void end() override { stream_.text("0\nENDSEC\n0\nEOF\n"); }
  // Without a decimal point a reader may take a number for an integer.
  void real(double value) {
    std::array<char, 32> buffer{};
    const std::string_view text(buffer.data(), std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr);
    stream_.text(text);
    stream_.text(text.find_first_of(".e") == std::string_view::npos ? ".0\n" : "\n");
  }
};

}  // namespace

OpenedWriter open_dxf(const std::filesystem::path& path, const MeshHead&) {
  BOOST_OUTCOME_TRY(file, OutputFile::create(path));
  return std::make_unique<DxfWriter>(std::move(file));
}

}  // namespace tessera::exports
