#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <limits>
#include <random>
#include <stdexcept>

#include "tests/query/cgal_answers.h"
#include "tests/query/query_testing.h"

namespace tessera {
namespace {

using query::Area;
using query::Polygon;
using test::QuerySample;

std::vector<Point> corners_of(const QuerySample& sample, const IdCell& cell) {
  std::vector<Point> corners;
  for (int k = 0; k <= sample.dimension(); ++k)
    corners.push_back(sample.points()[cell[static_cast<std::size_t>(k)].value]);
  return corners;
}

std::vector<IdCell> found(const query::StoredTriangulation& result, const Area& area) {
  const auto set = result.cells(area, {.bytes_max = std::uint64_t{1} << 30}, {});
  if (!set) throw std::runtime_error(set.error().where);
  const TileMesh& mesh = set.value().mesh.mesh;
  const std::size_t corners = static_cast<std::size_t>(mesh.dimension) + 1;
  std::vector<IdCell> cells;
  for (std::size_t i = 0; i < mesh.cell_ghost.size(); ++i) {
    IdCell cell{infinite_id, infinite_id, infinite_id, infinite_id};
    for (std::size_t k = 0; k < corners; ++k) {
      const auto v = static_cast<std::size_t>(mesh.cells[i * corners + k]);
      cell[k] = mesh.ids[v];
      double plane = 0;
      std::memcpy(&plane, &set.value().mesh.rows[12 * v + 4], sizeof plane);
      EXPECT_EQ(plane, test::plane_at(mesh.points[v]));
    }
    std::sort(cell.begin(), cell.end());
    cells.push_back(cell);
  }
  std::sort(cells.begin(), cells.end());
  return cells;
}

class CellsOf : public testing::TestWithParam<test::SampleKind> {};
class FlatCellsOf : public testing::TestWithParam<test::SampleKind> {};
std::vector<test::SampleKind> flat_kinds() {
  auto kinds = test::sample_kinds();
  std::erase_if(kinds, [](const auto& kind) { return kind.dimension == 3; });
  return kinds;
}
INSTANTIATE_TEST_SUITE_P(Kinds, FlatCellsOf, testing::ValuesIn(flat_kinds()),
                         [](const auto& kind) { return testing::PrintToString(kind.param); });
INSTANTIATE_TEST_SUITE_P(Kinds, CellsOf, testing::ValuesIn(test::sample_kinds()),
                         [](const auto& kind) { return testing::PrintToString(kind.param); });

TEST_P(CellsOf, ABoxAreThoseThatMeetItByCgal) {
  const QuerySample sample(GetParam(), 60);
  const auto result = sample.open();
  const auto ends = sample.questions(40, 8);
  std::size_t empty = 0;
  for (std::size_t i = 0; i + 1 < ends.size(); i += 2) {
    Bounds box;
    box.add(ends[i]);
    if (i % 8 != 0) box.add(ends[i + 1]);  // a point is a box, too
    std::vector<IdCell> right;
    for (const auto& cell : sample.cells())
      if (test::cgal_meets(corners_of(sample, cell), box)) right.push_back(cell);
    EXPECT_EQ(found(result, {.box = box}), right) << i;
    empty += right.empty() ? 1 : 0;
  }
  EXPECT_LT(empty, 15u);
}

TEST_P(FlatCellsOf, APolygonAreThoseThatMeetItByCgal) {
  const QuerySample sample(GetParam(), 60);
  const auto result = sample.open();
  const auto some = sample.questions(60, 9);
  for (std::size_t i = 0; i + 2 < some.size(); i += 3) {
    const std::vector<Point> ring{some[i], some[i + 1], some[i + 2]};
    if (ring[0] == ring[1] || ring[1] == ring[2] || ring[0] == ring[2]) continue;
    const Polygon polygon({ring});
    std::vector<IdCell> right;
    for (const auto& cell : sample.cells())
      if (test::cgal_meets(corners_of(sample, cell), ring)) right.push_back(cell);
    EXPECT_EQ(found(result, {.box = polygon.bounds(), .polygon = polygon}), right) << i;
  }
}

TEST(Cells, OfAPolygonInSpaceAreThoseAboveAndBelowIt) {
  const QuerySample sample({.cloud = "uniform", .dimension = 3, .number = 3}, 200);
  // A ring with a hole in it, in the middle of the cloud.
  Bounds bounds;
  for (const Point& p : sample.points()) bounds.add(p);
  const auto at = [&](double u, double v) {
    return Point{bounds.lo.x + u * (bounds.hi.x - bounds.lo.x), bounds.lo.y + v * (bounds.hi.y - bounds.lo.y), 0};
  };
  const std::vector<Point> outer{at(.2, .2), at(.9, .3), at(.8, .8), at(.1, .7)};
  const std::vector<Point> hole{at(.45, .45), at(.55, .45), at(.5, .55)};
  const Polygon polygon({outer, hole});
  Area area{.box = polygon.bounds(), .polygon = polygon};
  area.box.lo.z = -std::numeric_limits<double>::infinity();
  area.box.hi.z = std::numeric_limits<double>::infinity();
  std::vector<IdCell> right;
  for (const auto& cell : sample.cells()) {
    const auto p = corners_of(sample, cell);
    bool meets = false;
    for (std::size_t k = 0; k < 4; ++k)
      meets = meets || test::cgal_meets(std::vector{p[k == 0 ? 3 : 0], p[k == 1 ? 3 : 1], p[k == 2 ? 3 : 2]}, outer);
    if (meets) right.push_back(cell);
  }
  EXPECT_LT(right.size(), sample.cells().size());
  // No cell of this sample is so small that it would fit into the hole.
  EXPECT_EQ(found(sample.open(), area), right);
}

TEST(Cells, LeavesOutWhatIsInsideAHole) {
  const QuerySample sample({.cloud = "uniform", .dimension = 2, .number = 4}, 2000);
  Bounds bounds;
  for (const Point& p : sample.points()) bounds.add(p);
  const auto square = [&](double from, double to) {
    const auto x = [&](double u) { return bounds.lo.x + u * (bounds.hi.x - bounds.lo.x); };
    const auto y = [&](double v) { return bounds.lo.y + v * (bounds.hi.y - bounds.lo.y); };
    return std::vector<Point>{{x(from), y(from), 0}, {x(to), y(from), 0}, {x(to), y(to), 0}, {x(from), y(to), 0}};
  };
  const Polygon with_hole({square(.2, .8), square(.4, .6)}), filled({square(.2, .8)});
  const Polygon hole({square(.4, .6)}), inner({square(.45, .55)});
  const auto result = sample.open();
  const auto of = [&](const Polygon& polygon) { return found(result, {.box = polygon.bounds(), .polygon = polygon}); };
  const auto around = of(with_hole), all = of(filled), meet_hole = of(hole), deep = of(inner);
  EXPECT_LT(around.size(), all.size());
  EXPECT_TRUE(std::includes(all.begin(), all.end(), around.begin(), around.end()));
  std::vector<IdCell> left_out;
  std::set_difference(all.begin(), all.end(), around.begin(), around.end(), std::back_inserter(left_out));
  EXPECT_TRUE(std::includes(meet_hole.begin(), meet_hole.end(), left_out.begin(), left_out.end()));
  EXPECT_TRUE(std::includes(left_out.begin(), left_out.end(), deep.begin(), deep.end()));
}

TEST(Cells, ReadsOnlyTheTilesThatHaveThem) {
  const QuerySample sample({.cloud = "uniform", .dimension = 2, .number = 10}, 3000);
  Bounds box;
  const Point& p = sample.points()[0];
  box.add(p);
  const auto result = sample.open();
  EXPECT_FALSE(found(result, {.box = box}).empty());
  EXPECT_LE(result.tiles_read(), 3u);
}

TEST(Cells, AreTheSameWithHardlyAnyMemory) {
  const QuerySample sample({.cloud = "uniform", .dimension = 3, .number = 6}, 400);
  Bounds box;
  box.add(sample.points()[0]);
  box.add(sample.points()[1]);
  const auto little = sample.open(1);
  EXPECT_EQ(found(little, {.box = box}), found(sample.open(), {.box = box}));
  const auto none = little.cells({.box = box}, {.bytes_max = 10}, {});
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, Errc::memory);
}

TEST(GeoJson, GivesThePolygonsOfADocument) {
  const test::TemporaryFolder folder;
  const auto path = folder.path() / "area.geojson";
  std::ofstream(path) << R"({"type": "FeatureCollection", "features": [
    {"type": "Feature", "geometry": {"type": "Polygon", "coordinates": [[[0,0],[4,0],[4,4],[0,0]]]}},
    {"type": "Feature", "geometry": {"type": "MultiPolygon", "coordinates": [[[[10,0,5],[14,0,5],[14,4,5]]]]}}]})";
  const auto polygon = Polygon::read_geojson(path);
  ASSERT_TRUE(polygon) << polygon.error().where;
  EXPECT_EQ(polygon.value().bounds().hi.x, 14);
  const std::vector<Point> in{{12, 1, 0}, {13, 1, 0}, {13, 1.5, 0}}, between{{5, 1, 0}, {9, 1, 0}, {9, 2, 0}};
  EXPECT_TRUE(polygon.value().meets(in));
  EXPECT_FALSE(polygon.value().meets(between));
}

TEST(GeoJson, RefusesWhatIsNoPolygonWithItsPlace) {
  const test::TemporaryFolder folder;
  const auto path = folder.path() / "area.geojson";
  std::string deep;
  for (int i = 0; i < 100000; ++i) deep += R"({"type":"GeometryCollection","geometries":[)";
  for (int i = 0; i < 100000; ++i) deep += "]}";
  const std::pair<std::string, std::string> documents[] = {
      {"{", "is not JSON"},
      {"[1]", "it is no GeoJSON object"},
      {R"({"type": "Point", "coordinates": [0, 0]})", "neither Polygon"},
      {R"({"type": "FeatureCollection", "features": []})", "has no polygon"},
      {R"({"type": "Feature", "geometry": null})", "geometry is no GeoJSON object"},
      {R"({"type": "Polygon", "coordinates": [[[0,0],[1,1],[0,0]]]})", "coordinates[0] has fewer than three"},
      {R"({"type": "Polygon", "coordinates": [[[0,0],[1,"a"],[0,1]]]})", "coordinates[0][1] is no position"},
      {R"({"type": "Polygon", "coordinates": [[[0,0],[1,1e999],[0,1]]]})", ""},
      {deep, "too deep"}};
  for (const auto& [document, says] : documents) {
    std::ofstream(path) << document;
    const auto polygon = Polygon::read_geojson(path);
    ASSERT_FALSE(polygon) << document.substr(0, 80);
    EXPECT_EQ(polygon.error().code, Errc::bad_input);
    EXPECT_NE(polygon.error().where.find(says), std::string::npos) << polygon.error().where.substr(0, 300);
    EXPECT_NE(polygon.error().where.find("area.geojson"), std::string::npos);
  }
}

}  // namespace
}  // namespace tessera
