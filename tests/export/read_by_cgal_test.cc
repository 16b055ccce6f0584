// OFF and PLY, merged and tile by tile, as CGAL reads them: the points bit for bit, and the cells of the store.
#include <CGAL/IO/polygon_soup_io.h>
#include <CGAL/Simple_cartesian.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <set>

#include "src/result/export/export.h"
#include "tests/store/sample_result.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using CgalPoint = CGAL::Simple_cartesian<double>::Point_3;
using Cells = std::set<std::vector<Point>>;  // each as its corners, in order

struct Soup {
  std::vector<CgalPoint> points;
  std::vector<std::vector<std::size_t>> polygons;
};

void add_cells(const Soup& soup, Cells& cells) {
  for (const auto& polygon : soup.polygons) {
    std::vector<Point> corners;
    for (const auto v : polygon) corners.push_back({soup.points[v].x(), soup.points[v].y(), soup.points[v].z()});
    EXPECT_TRUE(cells.insert(corners).second) << "every cell once";
  }
}

Soup read(const fs::path& path) {
  Soup soup;
  EXPECT_TRUE(CGAL::IO::read_polygon_soup(path.string(), soup.points, soup.polygons)) << path;
  return soup;
}

class ReadByCgal : public testing::TestWithParam<std::tuple<test::Shape, int, std::string>> {};

TEST_P(ReadByCgal, CellsAndCoordinatesAreThoseOfTheStore) {
  const auto& [shape, dimension, format] = GetParam();
  auto points = test::sample_points(shape, dimension, 400);
  for (auto& p : points) {  // what needs all 17 digits, large and small
    p = {p.x * 1e300 / 3, p.y / 3e-7, p.z / 7};
  }
  const auto meshes = test::sample_tiles(points, dimension, 5);
  const test::TemporaryFolder folder, target;
  test::store_sample(folder.path(), meshes);
  Cells expected;
  const std::size_t corners = static_cast<std::size_t>(dimension) + 1;
  for (const auto& mesh : meshes)
    for (std::size_t i = 0; i < mesh.cell_ghost.size(); ++i) {
      std::vector<Point> cell;
      for (std::size_t k = 0; k < corners; ++k)
        cell.push_back(mesh.points[static_cast<std::size_t>(mesh.cells[i * corners + k])]);
      if (mesh.cell_ghost[i] == 0) expected.insert(cell);
    }

  ASSERT_TRUE(export_result(folder.path(), target.path() / ("mesh." + format), {}, {}));
  const Soup merged = read(target.path() / ("mesh." + format));
  EXPECT_EQ(merged.points.size(), points.size());
  Cells cells;
  add_cells(merged, cells);
  EXPECT_EQ(cells, expected);

  ASSERT_TRUE(export_result(folder.path(), target.path() / "tiles", {.format = format}, {}));
  cells.clear();
  for (const auto& file : fs::directory_iterator(target.path() / "tiles")) add_cells(read(file.path()), cells);
  EXPECT_EQ(cells, expected);
}

// CGAL knows no tetrahedra in PLY.
INSTANTIATE_TEST_SUITE_P(Off, ReadByCgal,
                         testing::Combine(testing::Values(test::Shape::uniform, test::Shape::lattice),
                                          testing::Values(2, 3), testing::Values("off")));
INSTANTIATE_TEST_SUITE_P(FlatPly, ReadByCgal,
                         testing::Combine(testing::Values(test::Shape::uniform, test::Shape::lattice),
                                          testing::Values(2), testing::Values("ply", "obj")));

}  // namespace
}  // namespace tessera
