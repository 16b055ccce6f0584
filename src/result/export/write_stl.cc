// STL, binary: a normal and three corners for each triangle, as 32-bit floats. The format has no vertices, units or
// attributes. Triangles that share a vertex have the same coordinates there.
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "src/result/export/formats.h"
#include "src/result/export/stream_writer.h"

namespace tessera::exports {

namespace {

using Floats = std::array<float, 3>;

// Not inline: where corners are rounded to floats in the same function, GCC 12 at -O3 vectorises both and drops some of
// the rounding, so that the normal belongs to other corners than those that are written.
[[gnu::noinline]] Floats normal_of(const std::array<Floats, 3>& corners) {
  const auto edge = [&](std::size_t to, std::size_t axis) {
    return static_cast<double>(corners[to][axis]) - static_cast<double>(corners[0][axis]);
  };
  std::array<double, 3> normal{};
  double square = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t b = (axis + 1) % 3, c = (axis + 2) % 3;
    normal[axis] = edge(1, b) * edge(2, c) - edge(1, c) * edge(2, b);
    square += normal[axis] * normal[axis];
  }
  Floats out{};
  if (square == 0) return out;  // rounding has flattened the triangle: readers take a normal of 0 as unknown
  for (std::size_t axis = 0; axis < 3; ++axis) out[axis] = static_cast<float>(normal[axis] / std::sqrt(square));
  return out;
}

class StlWriter : public StreamWriter {
 public:
  StlWriter(OutputFile file, const MeshHead& head)
      : StreamWriter(std::move(file)), corner_(head.corner.value_or(Point{})) {
    std::string title = "tessera " + head.software_version + (head.corner ? ", " + head.corner_comment() : "");
    title.resize(80, ' ');
    stream_.text(title);
    stream_.value(static_cast<std::uint32_t>(head.cells));
  }

  void vertex(const VertexView&) override {}
  void cell(const CellView& cell) override {
    std::array<Floats, 3> corners;
    for (std::size_t k = 0; k < 3; ++k)
      for (int axis = 0; axis < 3; ++axis)
        corners[k][static_cast<std::size_t>(axis)] = static_cast<float>(cell.at[k][axis] - corner_[axis]);
    stream_.value(normal_of(corners));
    stream_.value(corners);
    stream_.value(std::uint16_t{0});
  }

 private:
  Point corner_;
};

}  // namespace

OpenedWriter open_stl(const std::filesystem::path& path, const MeshHead& head) {
  BOOST_OUTCOME_TRY(file, OutputFile::create(path));
  return std::make_unique<StlWriter>(std::move(file), head);
}

}  // namespace tessera::exports
