// The flat kernel in 2D against CGAL's on whole clouds: built, and built from a half and inserted into.
//   plane_cases POINTS_MAX FOLDER...
// Reads the sets that gen.py writes: those in space are projected along z. Clouds of more than POINTS_MAX points are
// cut.
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "src/geometry/kernel/kernel.h"
#include "src/tiling/routed_cloud.h"

namespace tessera::testing {
namespace {

namespace fs = std::filesystem;
using Corners = std::array<Vertex, 3>;

std::vector<Point> read(const fs::path& path, std::size_t most) {
  const bool planar = std::set<std::string>{"grid2", "circle2_int", "uniform2", "collinear2"}.contains(path.stem());
  std::vector<LocalPoint> list;
  std::ifstream file(path, std::ios::binary);
  for (double c[3]; list.size() < most && file.read(reinterpret_cast<char*>(c), planar ? 16 : 24);) {
    const Point p{c[0], c[1], 0};
    if (is_finite(p)) list.push_back({without_negative_zero(p), list.size()});
  }
  if (list.empty()) return {};
  return order_points(list, 2).points;
}

// Each triangle from its least vertex on, so that orientation counts.
std::vector<Corners> triangles(const Kernel& kernel) {
  const CellList list = kernel.cells();
  std::vector<Corners> all;
  for (std::size_t c = 0; c < list.vertices.size(); c += 3) {
    Corners t{list.vertices[c], list.vertices[c + 1], list.vertices[c + 2]};
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
    all.push_back(t);
  }
  std::sort(all.begin(), all.end());
  return all;
}

std::string compare(const Kernel& flat, const Kernel& cgal) {
  if (flat.dimension() != cgal.dimension()) return "another dimension";
  if (flat.dimension() < 2) return "";
  return triangles(flat) == triangles(cgal) ? "" : "other triangles";
}

std::string check_cloud(const std::vector<Point>& points) {
  const auto flat = make_kernel(2, KernelKind::flat), cgal = make_kernel(2, KernelKind::cgal);
  flat->build(points, KeepPoints::borrowed);
  cgal->build(points);
  if (const std::string wrong = compare(*flat, *cgal); !wrong.empty()) return wrong;
  std::vector<Point> rest = points;
  std::shuffle(rest.begin(), rest.end(), std::mt19937_64(1));
  const std::vector<Point> first(rest.begin(), rest.begin() + static_cast<std::ptrdiff_t>(rest.size() / 2));
  flat->build(first);
  cgal->build(first);
  std::vector<Vertex> around, expected;
  for (std::size_t i = first.size(); i < rest.size(); ++i) {
    const auto mode = i % 4 == 0 ? InsertMode::always : InsertMode::if_local_neighbour;
    const Insertion got = flat->insert(rest[i], false, mode, around),
                    made = cgal->insert(rest[i], false, mode, expected);
    std::sort(around.begin(), around.end());
    std::sort(expected.begin(), expected.end());
    if (got.vertex != made.vertex || got.inserted != made.inserted || around != expected)
      return "insert() answers otherwise";
  }
  for (Vertex v = 3; v < flat->vertices(); v += 7) {
    flat->remove(v);
    cgal->remove(v);
  }
  return compare(*flat, *cgal);
}

}  // namespace
}  // namespace tessera::testing

int main(int argc, char** argv) {
  namespace fs = std::filesystem;
  using namespace tessera::testing;
  const std::size_t most = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 0;
  std::vector<fs::path> files;
  for (int i = 2; i < argc; ++i) {
    for (const auto& file : fs::directory_iterator(argv[i])) {
      if (file.path().extension() == ".bin") files.push_back(file.path());
    }
  }
  std::sort(files.begin(), files.end());
  bool equal = !files.empty();
  for (const auto& file : files) {
    const auto points = read(file, most);
    const std::string wrong = check_cloud(points);
    std::printf("%s: %zu points: %s\n", file.filename().c_str(), points.size(),
                wrong.empty() ? "equal" : wrong.c_str());
    equal &= wrong.empty();
  }
  return equal ? 0 : 1;
}
