#include <gtest/gtest.h>

#include <map>
#include <random>
#include <set>

#include "src/tiling/routed_cloud.h"
#include "tests/tiling/clouds.h"

namespace tessera {
namespace {

std::vector<LocalPoint> labelled(const std::vector<Point>& points) {
  std::vector<LocalPoint> result;
  for (std::size_t i = 0; i < points.size(); ++i) result.push_back({points[i], 1000 + 3 * i});
  return result;
}

class Ordered : public testing::TestWithParam<std::tuple<std::string, int>> {};

TEST_P(Ordered, PointsAreDistinctWithTheLowestIdAndNothingIsLost) {
  const auto& [name, dimension] = GetParam();
  const auto in = labelled(make_cloud(name, dimension, 5000));
  const LoadedTile out = order_points(in, dimension);
  std::map<Point, PointId> lowest;
  std::map<PointId, Point> place;
  for (const LocalPoint& p : in) {
    lowest.try_emplace(p.at, p.id);  // ids ascend, so the first is the lowest
    place.emplace(p.id, p.at);
  }
  ASSERT_EQ(out.points.size(), lowest.size());
  ASSERT_EQ(out.ids.size(), out.points.size());
  ASSERT_EQ(out.points.size() + out.duplicates.size(), in.size());
  std::set<PointId> seen;
  for (std::size_t i = 0; i < out.points.size(); ++i) {
    ASSERT_EQ(out.ids[i], lowest.at(out.points[i]));
    ASSERT_TRUE(seen.insert(out.ids[i]).second);
  }
  ASSERT_TRUE(std::is_sorted(out.duplicates.begin(), out.duplicates.end()));
  for (const auto& [duplicate, kept] : out.duplicates) {
    ASSERT_TRUE(seen.insert(duplicate).second);
    ASSERT_EQ(kept, lowest.at(place.at(duplicate)));
  }
  ASSERT_EQ(seen.size(), in.size());
}

TEST_P(Ordered, IsAFunctionOfTheSetOfPoints) {
  const auto& [name, dimension] = GetParam();
  auto in = labelled(make_cloud(name, dimension, 5000));
  const LoadedTile one = order_points(in, dimension);
  std::shuffle(in.begin(), in.end(), std::mt19937_64(3));
  const LoadedTile other = order_points(in, dimension);
  EXPECT_EQ(one.points, other.points);
  EXPECT_EQ(one.ids, other.ids);
  EXPECT_EQ(one.duplicates, other.duplicates);
}

INSTANTIATE_TEST_SUITE_P(, Ordered, testing::Combine(testing::ValuesIn(cloud_names()), testing::Values(2, 3)),
                         [](const auto& info) {
                           return std::get<0>(info.param) + "_" + std::to_string(std::get<1>(info.param)) + "d";
                         });

double path_length(const std::vector<Point>& points) {
  double length = 0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const Point& a = points[i - 1];
    const Point& b = points[i];
    length += std::hypot(a.x - b.x, a.y - b.y, a.z - b.z);
  }
  return length;
}

TEST(Order, GoesFromNeighbourToNeighbour) {
  const auto cloud = make_cloud("uniform", 3, 20000);
  // A random order walks 0.66 a step; neighbours are 20000^-1/3 = 0.037 apart.
  EXPECT_LT(path_length(order_points(labelled(cloud), 3).points), 0.06 * 20000);
}

TEST(Order, HoldsForTheSmallSceneOfACloudWithAFarOutlier) {
  // At 21 bits over 1e9 metres, a cell is 477 m wide: the scene of one metre has a curve of its own.
  auto cloud = make_cloud("outlier", 3, 20000);
  auto ordered = order_points(labelled(cloud), 3).points;
  std::erase_if(ordered, [](const Point& p) { return p.x > 1; });
  EXPECT_LT(path_length(ordered), 0.06 * 20000);
}

}  // namespace
}  // namespace tessera
