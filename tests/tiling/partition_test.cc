#include "src/tiling/partition.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "src/tiling/affine_basis.h"
#include "tests/tiling/clouds.h"

namespace tessera {
namespace {

constexpr PartitionKind kinds[] = {PartitionKind::kdtree, PartitionKind::grid, PartitionKind::octree,
                                   PartitionKind::random};
constexpr double infinity = std::numeric_limits<double>::infinity();

bool disjoint(const Box& a, const Box& b) {
  for (int axis = 0; axis < 3; ++axis) {
    if (a.hi[axis] <= b.lo[axis] || b.hi[axis] <= a.lo[axis]) return true;
  }
  return false;
}

bool is_empty(const Box& b) { return !(b.lo.x < b.hi.x && b.lo.y < b.hi.y && b.lo.z < b.hi.z); }

// Points where boxes could disagree: combinations of border coordinates, the doubles beside them, and far away ones.
std::vector<Point> border_points(const Partition& partition, std::size_t count) {
  std::array<std::vector<double>, 3> at;
  for (int a = 0; a < 3; ++a) {
    at[a] = {0};
    if (a >= partition.dimension()) continue;
    at[a] = {std::numeric_limits<double>::max(), -1e300};
    for (const Box& box : partition.boxes()) {
      for (const double x : {box.lo[a], box.hi[a]}) {
        for (const double y : {x, std::nextafter(x, -infinity), std::nextafter(x, infinity)}) {
          if (std::isfinite(y)) at[a].push_back(y);
        }
      }
    }
  }
  std::vector<Point> points;
  std::mt19937_64 random(5);
  for (std::size_t i = 0; i < count; ++i) {
    Point p;
    for (int a = 0; a < 3; ++a) p[a] = at[a][random() % at[a].size()];
    points.push_back(without_negative_zero(p));
  }
  return points;
}

void expect_valid(const Partition& partition, const std::vector<Point>& cloud) {
  const auto& boxes = partition.boxes();
  ASSERT_EQ(boxes.size(), partition.tiles());
  if (partition.kind() == PartitionKind::random) {
    for (const Box& box : boxes) ASSERT_EQ(box, Box{});
    for (const Point& p : cloud) ASSERT_LT(partition.tile_of(p).value, partition.tiles());
    return;
  }
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    ASSERT_FALSE(is_empty(boxes[i])) << i;
    for (std::size_t j = 0; j < i && boxes.size() <= 512; ++j)
      ASSERT_TRUE(disjoint(boxes[i], boxes[j])) << i << ' ' << j;
    if (partition.dimension() == 2) {
      ASSERT_EQ(boxes[i].lo.z, -infinity);
      ASSERT_EQ(boxes[i].hi.z, infinity);
    }
  }
  // Cover: whatever the point, the tile it is sent to is one whose box holds it.
  auto points = border_points(partition, 20000);
  points.insert(points.end(), cloud.begin(), cloud.end());
  for (const Point& p : points) {
    const TileId tile = partition.tile_of(p);
    ASSERT_LT(tile.value, boxes.size());
    ASSERT_TRUE(boxes[tile.value].contains(p)) << p.x << ' ' << p.y << ' ' << p.z;
  }
}

class EveryCloud : public testing::TestWithParam<std::tuple<std::string, PartitionKind, int>> {};

TEST_P(EveryCloud, IsCoveredByDisjointBoxesWhateverTheNumberOfTiles) {
  const auto& [name, kind, dimension] = GetParam();
  const auto cloud = make_cloud(name, dimension, 2000);
  for (const std::uint32_t tiles : {1u, 2u, 7u, 64u, 1000u}) {
    SCOPED_TRACE(tiles);
    const Partition partition = Partition::build_tiles(kind, dimension, cloud, bounds_of(cloud), tiles);
    expect_valid(partition, cloud);
    EXPECT_GE(partition.tiles(), tiles);
    const std::uint32_t most = kind == PartitionKind::grid     ? tiles * 5 / 4
                               : kind == PartitionKind::octree ? tiles + (dimension == 2 ? 2 : 6)
                                                               : tiles;
    EXPECT_LE(partition.tiles(), most);
  }
}

TEST_P(EveryCloud, IsCoveredByDisjointBoxesWithALimit) {
  const auto& [name, kind, dimension] = GetParam();
  const auto cloud = make_cloud(name, dimension, 2000);
  for (const std::uint64_t limit : {std::uint64_t{0}, std::uint64_t{10}, std::uint64_t{300}, std::uint64_t{1} << 40}) {
    SCOPED_TRACE(limit);
    expect_valid(Partition::build(kind, dimension, cloud, bounds_of(cloud), cloud.size(), limit), cloud);
  }
}

TEST_P(EveryCloud, ComesBackFromJsonTheSame) {
  const auto& [name, kind, dimension] = GetParam();
  const auto cloud = make_cloud(name, dimension, 2000);
  const Partition partition = Partition::build_tiles(kind, dimension, cloud, bounds_of(cloud), 64);
  const auto back = Partition::from_json(partition.to_json());
  ASSERT_TRUE(back) << back.error().where;
  EXPECT_EQ(back.value().kind(), kind);
  EXPECT_EQ(back.value().dimension(), dimension);
  EXPECT_EQ(back.value().boxes(), partition.boxes());
  for (const Point& p : cloud) EXPECT_EQ(back.value().tile_of(p), partition.tile_of(p));
}

// What route() does with a full tile, by itself: a limit is met unless the points of a tile are all equal.
TEST_P(EveryCloud, CanBeSplitUntilOnlyEqualPointsShareATile) {
  const auto& [name, kind, dimension] = GetParam();
  const auto cloud = make_cloud(name, dimension, 500);
  Partition partition = Partition::build_tiles(kind, dimension, cloud, bounds_of(cloud), 2);
  for (bool again = true; again;) {
    again = false;
    std::map<std::uint32_t, std::vector<Point>> by_tile;
    for (const Point& p : cloud) by_tile[partition.tile_of(p).value].push_back(p);
    for (const auto& [tile, points] : by_tile) {
      const std::uint32_t before = partition.tiles();
      const bool all_equal = std::all_of(points.begin(), points.end(), [&](const Point& p) { return p == points[0]; });
      const bool split = partition.split(TileId{tile}, points);
      ASSERT_EQ(split, !all_equal && kind != PartitionKind::random);
      ASSERT_EQ(partition.tiles(), before + split);
      std::size_t kept = 0;
      for (const Point& p : points) {
        const std::uint32_t now = partition.tile_of(p).value;
        ASSERT_TRUE(now == tile || (split && now == before));
        kept += now == tile;
      }
      if (split) {
        ASSERT_GT(kept, 0u);
        ASSERT_LT(kept, points.size());
        again = true;
      }
    }
  }
  expect_valid(partition, cloud);
}

INSTANTIATE_TEST_SUITE_P(, EveryCloud,
                         testing::Combine(testing::ValuesIn(cloud_names()), testing::ValuesIn(kinds),
                                          testing::Values(2, 3)),
                         [](const auto& info) {
                           return std::get<0>(info.param) + "_" + name_of(std::get<1>(info.param)) + "_" +
                                  std::to_string(std::get<2>(info.param)) + "d";
                         });

TEST(KdTree, HalvesACloudWithoutTiesExactly) {
  const auto cloud = make_cloud("uniform", 3, 6400);
  const Partition partition = Partition::build_tiles(PartitionKind::kdtree, 3, cloud, bounds_of(cloud), 64);
  std::vector<int> counts(64);
  for (const Point& p : cloud) ++counts[partition.tile_of(p).value];
  for (const int count : counts) EXPECT_EQ(count, 100);
}

TEST(KdTree, MeetsTheLimitWhenTheSampleIsTheCloud) {
  const auto cloud = make_cloud("uniform", 3, 10000);
  for (const std::uint64_t limit : {77u, 1000u, 3334u, 9999u}) {
    const Partition partition = Partition::build(PartitionKind::kdtree, 3, cloud, bounds_of(cloud), 10000, limit);
    std::vector<std::uint64_t> counts(partition.tiles());
    for (const Point& p : cloud) ++counts[partition.tile_of(p).value];
    EXPECT_LE(*std::max_element(counts.begin(), counts.end()), limit);
    EXPECT_EQ(partition.tiles(), (10000 + limit - 1) / limit);
  }
}

TEST(KdTree, IsBalancedInOddNumbersToo) {
  const auto cloud = make_cloud("uniform", 2, 7000);
  const Partition partition = Partition::build_tiles(PartitionKind::kdtree, 2, cloud, bounds_of(cloud), 7);
  std::vector<int> counts(7);
  for (const Point& p : cloud) ++counts[partition.tile_of(p).value];
  for (const int count : counts) EXPECT_NEAR(count, 1000, 2);
}

TEST(KdTree, DoesNotDependOnTheOrderOfTheSample) {
  auto cloud = make_cloud("lattice", 3, 5000);
  const Partition one = Partition::build_tiles(PartitionKind::kdtree, 3, cloud, bounds_of(cloud), 50);
  std::shuffle(cloud.begin(), cloud.end(), std::mt19937_64(7));
  const Partition other = Partition::build_tiles(PartitionKind::kdtree, 3, cloud, bounds_of(cloud), 50);
  EXPECT_EQ(one.boxes(), other.boxes());
}

TEST(Grid, OfACubeIsCubic) {
  const Bounds cube{{0, 0, 0}, {8, 8, 8}};
  const Partition partition = Partition::build_tiles(PartitionKind::grid, 3, {}, cube, 64);
  EXPECT_EQ(partition.tiles(), 64u);
  EXPECT_EQ(partition.boxes()[partition.tile_of({3, 3, 3}).value], (Box{{2, 2, 2}, {4, 4, 4}}));
}

TEST(Grid, OfATerrainIsNotCutInHeight) {
  const Bounds flat{{0, 0, 100}, {1000, 1000, 110}};
  const Partition partition = Partition::build_tiles(PartitionKind::grid, 3, {}, flat, 16);
  for (const Box& box : partition.boxes()) EXPECT_EQ(box.hi.z, infinity);
}

TEST(Octree, HasAtMostLimitPointsInALeaf) {
  const auto cloud = make_cloud("uniform", 3, 5000);
  const Partition partition = Partition::build(PartitionKind::octree, 3, cloud, bounds_of(cloud), 5000, 100);
  std::vector<int> counts(partition.tiles());
  for (const Point& p : cloud) ++counts[partition.tile_of(p).value];
  EXPECT_LE(*std::max_element(counts.begin(), counts.end()), 100);
  EXPECT_EQ(partition.tiles() % 7, 1u);
}

TEST(Random, SpreadsPointsEvenly) {
  const auto cloud = make_cloud("uniform", 3, 70000);
  const Partition partition = Partition::build_tiles(PartitionKind::random, 3, cloud, bounds_of(cloud), 7);
  std::vector<int> counts(7);
  for (const Point& p : cloud) ++counts[partition.tile_of(p).value];
  for (const int count : counts) EXPECT_NEAR(count, 10000, 500);
}

TEST(Partition, NeverHasMoreTilesThanItsMaximum) {
  const auto cloud = make_cloud("uniform", 2, 1000);
  for (const PartitionKind kind : kinds) {
    const Partition partition = Partition::build_tiles(kind, 2, cloud, bounds_of(cloud), 4'000'000'000u);
    EXPECT_LE(partition.tiles(), Partition::tiles_max) << name_of(kind);
    EXPECT_GE(partition.tiles(), Partition::tiles_max / 5 * 4) << name_of(kind);
  }
}

TEST(Partition, KindsHaveNames) {
  for (const PartitionKind kind : kinds) EXPECT_EQ(parse_partition_kind(name_of(kind)).value(), kind);
  EXPECT_EQ(parse_partition_kind("voronoi").error().code, Errc::usage);
}

TEST(PartitionJson, IsRefusedWhenItIsNotAPartition) {
  const std::string good = R"({"kind":"kdtree","dimension":3,"tiles":3,"splits":[[0,1.5,1,-3],[1,2.0,-1,-2]]})";
  ASSERT_TRUE(Partition::from_json(good)) << Partition::from_json(good).error().where;
  const char* bad[] = {
      "",
      "{",
      "[]",
      "null",
      "{}",
      R"({"kind":"kdtree","dimension":3,"tiles":1})",
      R"({"kind":"voronoi","dimension":3,"tiles":1,"splits":[]})",
      R"({"kind":7,"dimension":3,"tiles":1,"splits":[]})",
      R"({"kind":"kdtree","dimension":4,"tiles":1,"splits":[]})",
      R"({"kind":"kdtree","dimension":3,"tiles":0,"splits":[]})",
      R"({"kind":"kdtree","dimension":3,"tiles":18446744073709551615,"splits":[]})",
      R"({"kind":"random","dimension":3,"tiles":99999999,"splits":[]})",
      R"({"kind":"random","dimension":3,"tiles":2,"splits":[[0,1.5,-1,-2]]})",
      R"({"kind":"kdtree","dimension":3,"tiles":2,"splits":[]})",
      R"({"kind":"kdtree","dimension":3,"tiles":2,"splits":{"a":1}})",
      R"({"kind":"kdtree","dimension":3,"tiles":2,"splits":[7]})",
      R"({"kind":"kdtree","dimension":3,"tiles":2,"splits":[[0,1.5,-1]]})",
      R"({"kind":"kdtree","dimension":3,"tiles":2,"splits":[[0,"1.5",-1,-2]]})",
      R"({"kind":"kdtree","dimension":3,"tiles":2,"splits":[[0,null,-1,-2]]})",
      R"({"kind":"kdtree","dimension":3,"tiles":2,"splits":[[0,1e999,-1,-2]]})",
      R"({"kind":"kdtree","dimension":3,"tiles":2,"splits":[[3,1.5,-1,-2]]})",
      R"({"kind":"kdtree","dimension":2,"tiles":2,"splits":[[2,1.5,-1,-2]]})",
      R"({"kind":"kdtree","dimension":3,"tiles":2,"splits":[[0,1.5,-1,-1]]})",
      R"({"kind":"kdtree","dimension":3,"tiles":2,"splits":[[0,1.5,-1,-3]]})",
      R"({"kind":"kdtree","dimension":3,"tiles":2,"splits":[[0,1.5,0,-2]]})",
      R"({"kind":"kdtree","dimension":3,"tiles":3,"splits":[[0,1.5,1,1],[1,2.0,-1,-2]]})",
      R"({"kind":"kdtree","dimension":3,"tiles":3,"splits":[[0,1.5,-1,-2],[1,2.0,-3,-2]]})",
      R"({"kind":"kdtree","dimension":3,"tiles":3,"splits":[[0,1.5,1,-3],[0,2.0,-1,-2]]})",
      R"({"kind":"kdtree","dimension":3,"tiles":3,"splits":[[0,1.5,2,-3],[1,2.0,-1,-2]]})",
  };
  for (const char* text : bad) {
    const auto result = Partition::from_json(text);
    ASSERT_FALSE(result) << text;
    EXPECT_EQ(result.error().code, Errc::corrupt) << text;
    EXPECT_FALSE(result.error().where.empty());
  }
}

TEST(PartitionJson, SurvivesEveryTruncation) {
  const auto cloud = make_cloud("uniform", 3, 100);
  const std::string text = Partition::build_tiles(PartitionKind::kdtree, 3, cloud, bounds_of(cloud), 7).to_json();
  for (std::size_t n = 0; n < text.size(); ++n) EXPECT_FALSE(Partition::from_json(text.substr(0, n)));
}

TEST(Partition, KeepsItsPeriodAndRefusesOthers) {
  Partition partition;
  EXPECT_EQ(partition.to_json().find("period"), std::string::npos);
  partition.set_period({{100, 0, 0.75}});
  const std::string text = partition.to_json();
  const auto read = Partition::from_json(text);
  ASSERT_TRUE(read) << read.error().where;
  EXPECT_EQ(read.value().period(), partition.period());
  for (const char* wrong :
       {"[100.0,0.0]", "[0.0,0.0,0.0]", "[-1.0,0.0,0.0]", "[0.1,0.0,0.0]", "[1e300,0.0,0.0]", "7", "[\"a\",0.0,0.0]"}) {
    std::string other = text;
    const auto at = other.find("[100.0,0.0,0.75]");
    ASSERT_NE(at, std::string::npos) << text;
    other.replace(at, 16, wrong);
    EXPECT_FALSE(Partition::from_json(other)) << wrong;
  }
}

TEST(AffineBasis, SpansTheAxesWithoutAPeriod) {
  const auto point = [](double x, double y, double z, std::uint64_t id) { return LocalPoint{{x, y, z}, PointId{id}}; };
  const auto rank = [](const Period& period, const std::vector<LocalPoint>& points) {
    AffineBasis basis(3, period);
    basis.add(points);
    return std::pair(basis.rank(), basis.complete());
  };
  const std::vector<LocalPoint> one{point(1, 2, 3, 0)}, plane{point(1, 2, 3, 0), point(5, 7, 3, 1), point(9, 1, 3, 2)};
  EXPECT_EQ(rank({{8, 8, 8}}, one), std::pair(0, true));
  EXPECT_EQ(rank({{8, 8, 0}}, one), std::pair(0, false));
  EXPECT_EQ(rank({{8, 8, 0}}, plane), std::pair(0, false));
  EXPECT_EQ(rank({{8, 0, 8}}, plane), std::pair(1, true));
  EXPECT_EQ(rank({{0, 0, 8}}, plane), std::pair(2, true));
  EXPECT_EQ(rank({{8, 0, 0}}, plane), std::pair(1, false));
  EXPECT_EQ(rank({}, plane), std::pair(2, false));
}

}  // namespace
}  // namespace tessera
