#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tests/query/cgal_answers.h"
#include "tests/query/query_testing.h"

namespace tessera {
namespace {

using test::QuerySample;

class EveryStar : public testing::TestWithParam<test::SampleKind> {};
INSTANTIATE_TEST_SUITE_P(Kinds, EveryStar, testing::ValuesIn(test::sample_kinds()),
                         [](const auto& kind) { return testing::PrintToString(kind.param); });

TEST_P(EveryStar, HasTheCellsNeighborsAndVoronoiVolumeThatCgalHas) {
  const QuerySample sample(GetParam(), 80);
  const test::CgalAnswers cgal(sample.points(), sample.dimension());
  const auto result = sample.open();
  for (std::uint64_t i = 0; i < sample.points().size(); i += 3) {
    const auto found = result.star(PointId{i}, {}, {});
    ASSERT_TRUE(found) << found.error().where;
    const query::Star& star = found.value();
    EXPECT_EQ(star.vertex.id, PointId{i});
    EXPECT_EQ(star.vertex.at, sample.points()[i]);
    EXPECT_EQ(star.vertex.owner, sample.owner(PointId{i}));

    std::vector<IdCell> right, got;
    std::set<PointId> neighbors;
    for (const auto& cell : sample.cells()) {
      if (std::find(cell.begin(), cell.end(), PointId{i}) == cell.end()) continue;
      right.push_back(cell);
      neighbors.insert(cell.begin(), cell.end());
    }
    neighbors.erase(PointId{i});
    neighbors.erase(query::no_id);
    for (const auto& cell : star.cells) {
      got.push_back(test::ids_of(cell));
      TileId lowest = sample.owner(cell.vertices[0]);
      for (std::size_t k = 1; k <= static_cast<std::size_t>(sample.dimension()); ++k)
        lowest = std::min(lowest, sample.owner(cell.vertices[k]));
      EXPECT_EQ(cell.tile, lowest);
    }
    std::sort(got.begin(), got.end());
    EXPECT_EQ(got, right) << i;
    EXPECT_TRUE(std::equal(star.neighbors.begin(), star.neighbors.end(), neighbors.begin(), neighbors.end(),
                           [](const query::Vertex& v, PointId id) { return v.id == id; }));

    const double volume = cgal.voronoi_volume(PointId{i});
    if (std::isinf(volume)) {
      EXPECT_TRUE(std::isinf(star.voronoi_volume)) << i;
    } else {
      EXPECT_NEAR(star.voronoi_volume, volume, 1e-12 * volume) << i;
    }
  }
}

TEST(Star, TakesTheVertexThatStandsForADuplicate) {
  const auto points = test::sample_points(test::Shape::uniform, 2, 50);
  const test::TemporaryFolder folder;
  test::store_sample(folder.path(), test::sample_tiles(points, 2, 2), {}, {{PointId{50}, PointId{7}}});
  const auto result = query::StoredTriangulation::open(folder.path());
  ASSERT_TRUE(result);
  const auto star = result.value().star(PointId{50}, {}, {});
  ASSERT_TRUE(star) << star.error().where;
  EXPECT_EQ(star.value().vertex.id, PointId{7});
}

TEST(Star, SaysThatThereIsNoSuchVertex) {
  const QuerySample sample({.cloud = "uniform", .dimension = 2, .number = 2}, 50);
  const auto result = sample.open();
  const auto star = result.star(PointId{5000}, {}, {});
  ASSERT_FALSE(star);
  EXPECT_EQ(star.error().code, Errc::usage);
  const TileId other{1 - sample.owner(PointId{3}).value};
  const auto wrong_tile = result.star(PointId{3}, other, {});
  ASSERT_FALSE(wrong_tile);
  EXPECT_EQ(wrong_tile.error().code, Errc::usage);
  EXPECT_TRUE(result.star(PointId{3}, sample.owner(PointId{3}), {}));
}

}  // namespace
}  // namespace tessera
