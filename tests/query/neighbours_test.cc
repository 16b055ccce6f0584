#include "src/result/query/neighbours.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "tests/query/query_testing.h"

namespace tessera {
namespace {

using test::QuerySample;

class EveryNeighbour : public testing::TestWithParam<test::SampleKind> {};
INSTANTIATE_TEST_SUITE_P(Kinds, EveryNeighbour, testing::ValuesIn(test::sample_kinds()),
                         [](const auto& kind) { return testing::PrintToString(kind.param); });

TEST_P(EveryNeighbour, SharesACellWithTheVertex) {
  const QuerySample sample(GetParam(), 80);
  const auto result = sample.open();
  for (std::uint64_t i = 0; i < sample.points().size(); i += 3) {
    std::set<PointId> wanted;
    for (const auto& cell : sample.cells()) {
      if (std::find(cell.begin(), cell.end(), PointId{i}) == cell.end()) continue;
      wanted.insert(cell.begin(), cell.end());
    }
    wanted.erase(PointId{i});
    wanted.erase(query::no_id);
    const auto found = result.neighbours(PointId{i}, sample.owner(PointId{i}), {});
    ASSERT_TRUE(found) << found.error().where;
    EXPECT_EQ(found.value().ids, std::vector<PointId>(wanted.begin(), wanted.end()));
    EXPECT_EQ(found.value().asked, PointId{i});
    EXPECT_EQ(found.value().vertex, PointId{i});
    const bool on_hull = std::isinf(result.star(PointId{i}, {}, {}).value().voronoi_volume);
    EXPECT_EQ(found.value().on_hull, on_hull);
    EXPECT_TRUE(found.value().final);
  }
}

TEST(Neighbours, AreThoseOfThePointThatIsKeptForADuplicate) {
  const auto points = test::sample_points(test::Shape::uniform, 2, 50);
  const test::TemporaryFolder folder;
  test::store_sample(folder.path(), test::sample_tiles(points, 2, 2), {}, {{PointId{50}, PointId{7}}});
  const auto result = query::StoredTriangulation::open(folder.path());
  ASSERT_TRUE(result);
  const auto of_duplicate = result.value().neighbours(PointId{50}, {}, {});
  ASSERT_TRUE(of_duplicate) << of_duplicate.error().where;
  EXPECT_EQ(of_duplicate.value().vertex, PointId{7});
  EXPECT_EQ(of_duplicate.value().ids, result.value().neighbours(PointId{7}, {}, {}).value().ids);
  EXPECT_EQ(text_of(of_duplicate.value()).find("point 50 of the input is equal to vertex 7\n"), 0u);
}

TEST(Neighbours, OfAPointThatIsNoVertexAreAnError) {
  const QuerySample sample({.cloud = "uniform", .dimension = 2, .number = 2}, 50);
  const auto found = sample.open().neighbours(PointId{5000}, {}, {});
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code, Errc::usage);
}

TEST(Neighbours, AreToldAsTextAndAsJson) {
  query::Neighbours found{.asked = PointId{3}, .vertex = PointId{3}, .ids = {PointId{1}, PointId{9}}, .on_hull = true};
  EXPECT_EQ(text_of(found), "vertex 3, on the hull, has 2 neighbours: 1 9\n");
  EXPECT_EQ(json_of(found), "{\"asked\":3,\"vertex\":3,\"on_hull\":true,\"neighbors\":[1,9]}\n");
  found.on_hull = found.final = false;
  EXPECT_EQ(text_of(found, true),
            "vertex 3 has 2 neighbours: 1 9\n  not final: the whole triangulation may differ here\n");
  EXPECT_EQ(json_of(found, true), "{\"asked\":3,\"vertex\":3,\"on_hull\":false,\"neighbors\":[1,9],\"final\":false}\n");
}

}  // namespace
}  // namespace tessera
