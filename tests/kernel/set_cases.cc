// The flat kernel against CGAL's on whole clouds: built; built from a half and inserted into; the same, frozen.
//   set_cases POINTS_MAX PATH...
// A path is a file of points or a folder of them. .bin are doubles x y z as gen.py writes them (its planar sets are
// left out); other formats are those Tessera reads. Clouds of more than POINTS_MAX points are cut.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "src/input/reader.h"
#include "src/tiling/routed_cloud.h"
#include "tests/kernel/differential.h"

namespace tessera::testing {
namespace {

namespace fs = std::filesystem;

std::vector<Point> read(const fs::path& path) {
  std::vector<Point> points;
  if (path.extension() == ".bin") {
    std::ifstream file(path, std::ios::binary);
    for (double c[3]; file.read(reinterpret_cast<char*>(c), sizeof c);) points.push_back({c[0], c[1], c[2]});
    return points;
  }
  auto reader = open_reader(path);
  PointBatch batch;
  do {
    if (!reader || !reader.value()->next(batch)) return points;
    points.insert(points.end(), batch.points.begin(), batch.points.end());
  } while (!batch.points.empty());
  return points;
}

// In Hilbert order, distinct and finite.
std::vector<Point> ordered(const std::vector<Point>& points, std::size_t most) {
  std::vector<LocalPoint> list;
  for (const Point& p : points) {
    if (is_finite(p) && list.size() < most) list.push_back({without_negative_zero(p), list.size()});
  }
  if (list.empty()) return {};
  return order_points(list, 3).points;
}

// The lower half along x is local, the others come in random order.
std::string insert_half(const std::vector<Point>& points, bool freeze, std::size_t& frozen) {
  std::vector<double> xs;
  for (const Point& p : points) xs.push_back(p.x);
  std::nth_element(xs.begin(), xs.begin() + static_cast<std::ptrdiff_t>(xs.size() / 2), xs.end());
  Box box;
  box.hi.x = xs[xs.size() / 2];
  std::vector<Point> locals, others;
  for (const Point& p : points) (box.contains(p) ? locals : others).push_back(p);
  std::shuffle(others.begin(), others.end(), std::mt19937_64(1));
  KernelPair pair(true);
  pair.build(locals, KeepPoints::borrowed);
  for (std::size_t i = 0; i < others.size() && pair.wrong().empty(); ++i) {
    if (freeze && i == std::min<std::size_t>(4, others.size() - 1)) pair.freeze(box);
    pair.insert(others[i], false, i % 4 == 0 ? InsertMode::always : InsertMode::if_local_neighbour);
    if (i % 20000 == 5) pair.save_and_load();
  }
  pair.compare_edges(static_cast<Vertex>(locals.size()) + 1);
  pair.compare_cells();
  frozen = pair.frozen_cells();
  return pair.wrong();
}

bool check_cloud(const fs::path& path, std::size_t most) {
  const std::vector<Point> points = ordered(read(path), most);
  KernelPair whole(true);
  whole.build(points, KeepPoints::borrowed);
  whole.compare_cells();
  std::size_t frozen = 0;
  std::string wrong = whole.wrong();
  if (wrong.empty() && !points.empty()) wrong = insert_half(points, false, frozen);
  if (wrong.empty() && !points.empty()) wrong = insert_half(points, true, frozen);
  std::printf("%s: %zu points, dimension %d, %zu cells frozen: %s\n", path.filename().c_str(), points.size(),
              whole.flat().dimension(), frozen, wrong.empty() ? "equal" : wrong.c_str());
  return wrong.empty();
}

}  // namespace
}  // namespace tessera::testing

int main(int argc, char** argv) {
  namespace fs = std::filesystem;
  const std::set<std::string> planar{"grid2", "circle2_int", "uniform2", "collinear2"};
  const std::set<std::string> kinds{".bin", ".las", ".ply", ".xyz"};
  std::vector<fs::path> files;
  for (int i = 2; i < argc; ++i) {
    if (!fs::is_directory(argv[i])) {
      files.emplace_back(argv[i]);
      continue;
    }
    for (const auto& file : fs::directory_iterator(argv[i])) {
      const fs::path& path = file.path();
      if (kinds.contains(path.extension()) && !planar.contains(path.stem())) files.push_back(path);
    }
  }
  std::sort(files.begin(), files.end(),
            [](const auto& a, const auto& b) { return fs::file_size(a) < fs::file_size(b); });
  const std::size_t most = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 0;
  bool equal = !files.empty();
  for (const auto& file : files) equal &= tessera::testing::check_cloud(file, most);
  return equal ? 0 : 1;
}
