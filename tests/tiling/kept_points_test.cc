// Of equal points the right one, against looking at all of them, whatever the tiles and wherever the points are cut.
#include "src/tiling/kept_points.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <random>

#include "src/base/option.h"
#include "tests/tiling/run_fixture.h"

namespace tessera {
namespace {

struct Expected {
  std::map<Point, KeptCandidate> vertices;
  std::map<PointId, PointId> duplicates;
  std::uint64_t other_heights = 0;
};

bool same_height(double a, double b) { return std::isnan(a) ? std::isnan(b) : a == b; }

// In words of its own: the best of each place by one look at all points.
Expected brute_force(const std::vector<Point>& points, DuplicatePolicy keep) {
  std::map<Point, std::vector<std::uint64_t>> places;
  for (std::uint64_t i = 0; i < points.size(); ++i) places[{points[i].x, points[i].y, 0}].push_back(i);
  Expected expected;
  for (const auto& [at, ids] : places) {
    std::uint64_t best = keep == DuplicatePolicy::last ? ids.back() : ids.front();
    for (const std::uint64_t id : ids) {
      const double z = points[id].z, than = points[best].z;
      const bool number = !std::isnan(z);
      if (keep == DuplicatePolicy::lowest && number && !(than <= z)) best = id;
      if (keep == DuplicatePolicy::highest && number && !(than >= z)) best = id;
    }
    expected.vertices[at] = {PointId{best}, points[best].z};
    for (const std::uint64_t id : ids) {
      if (id == best) continue;
      expected.duplicates[PointId{id}] = PointId{best};
      expected.other_heights += !same_height(points[id].z, points[best].z);
    }
  }
  return expected;
}

class KeptPoints : public RunFixture {
 protected:
  // Heights are seldom unique, and some are no numbers.
  static std::vector<Point> cloud(std::size_t n, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    const auto below = [&](std::uint64_t end) { return static_cast<double>(random() % end); };
    std::vector<Point> points;
    for (std::size_t i = 0; i < n; ++i) {
      Point p{below(40), below(40), below(5) - 2};
      if (random() % 50 == 0) p.z = std::numeric_limits<double>::quiet_NaN();
      if (random() % 4 == 0) p = {7, 9, p.z};  // more of one place than of all others
      if (random() % 100 == 0) p = {-1000, -1000, p.z};
      points.push_back(p);
    }
    return points;
  }

  Result<RoutedCloud> route_heights(const std::vector<Point>& points, DuplicatePolicy keep,
                                    const RouteOptions& options) {
    CloudOptions wanted = in_dimension(2);
    wanted.keep = keep;
    return route(open_cloud(write_npy(points, 3), wanted), run_folder(), options, progress_, {});
  }
};

TEST_F(KeptPoints, AreThoseOfAllPointsWhateverTheTiles) {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const auto points = cloud(seed % 3 == 0 ? 30'000 : 700, seed);
    const RouteOptions tilings[] = {{.tiles = 1},
                                    {.tiles = 7},
                                    {.kind = PartitionKind::grid, .tiles = 9},
                                    {.kind = PartitionKind::random, .tiles = 5},
                                    {.max_points_per_tile = 50}};
    for (const auto keep :
         {DuplicatePolicy::first, DuplicatePolicy::last, DuplicatePolicy::lowest, DuplicatePolicy::highest}) {
      const Expected expected = brute_force(points, keep);
      const auto& tiling = tilings[(seed + static_cast<std::size_t>(keep)) % std::size(tilings)];
      const auto run = route_heights(points, keep, tiling);
      ASSERT_TRUE(run) << run.error().where;
      const auto again = open_run(run_folder());
      ASSERT_TRUE(again) << again.error().where;
      ASSERT_EQ(again.value().keep, keep);
      std::size_t vertices = 0;
      std::map<PointId, PointId> duplicates;
      std::uint64_t other_heights = 0;
      for (std::uint32_t t = 0; t < again.value().partition.tiles(); ++t) {
        const auto tile = load_tile(again.value(), TileId{t});
        ASSERT_TRUE(tile) << tile.error().where;
        for (std::size_t i = 0; i < tile.value().points.size(); ++i, ++vertices)
          ASSERT_EQ(tile.value().ids[i], expected.vertices.at(tile.value().points[i]).id) << name_of(keep);
        ASSERT_TRUE(std::is_sorted(tile.value().duplicates.begin(), tile.value().duplicates.end()));
        duplicates.insert(tile.value().duplicates.begin(), tile.value().duplicates.end());
        other_heights += tile.value().other_heights;
      }
      EXPECT_EQ(vertices, expected.vertices.size());
      EXPECT_EQ(duplicates, expected.duplicates);
      EXPECT_EQ(other_heights, expected.other_heights);
      for (const Seed& seed_point : again.value().seeds)
        ASSERT_EQ(seed_point.point.id, expected.vertices.at(seed_point.point.at).id) << name_of(keep);
      EXPECT_EQ(run.value().seeds, again.value().seeds);
    }
  }
}

TEST_F(KeptPoints, WithoutHeightsAreTheFirstOrTheLast) {
  std::vector<Point> points = cloud(900, 5);
  for (Point& p : points) p.z = 0;
  for (const auto keep : {DuplicatePolicy::first, DuplicatePolicy::last}) {
    CloudOptions wanted = in_dimension(2);
    wanted.keep = keep;
    const auto run = route(open_cloud(write_npy(points, 2), wanted), run_folder(), {.tiles = 4}, progress_, {});
    ASSERT_TRUE(run) << run.error().where;
    const Expected expected = brute_force(points, keep);
    for (std::uint32_t t = 0; t < 4; ++t) {
      const auto tile = load_tile(run.value(), TileId{t}).value();
      EXPECT_EQ(tile.other_heights, 0u);
      for (std::size_t i = 0; i < tile.points.size(); ++i)
        ASSERT_EQ(tile.ids[i], expected.vertices.at(tile.points[i]).id);
    }
  }
}

TEST_F(KeptPoints, AreAskedForWhereThereIsAChoice) {
  const auto refusal = [&](CloudOptions options, int columns = 3) {
    const auto cloud = Cloud::open({write_npy({{0, 0, 1}, {1, 0, 2}, {0, 1, 3}}, columns)}, options);
    return cloud.has_error() ? in_plain_words(cloud.error().where) : "";
  };
  EXPECT_EQ(refusal({.dimension = 3, .keep = DuplicatePolicy::last}),
            "keep=last: chooses among points of equal x and y, which become one vertex only in 2D (see dim)");
  EXPECT_EQ(refusal({.dimension = 2, .keep = DuplicatePolicy::lowest, .heights = false}),
            "keep=lowest: needs the heights, which z=false leaves out");
  EXPECT_EQ(refusal({.dimension = 0, .keep = DuplicatePolicy::highest}, 2),
            "keep=highest: needs heights, and no input file has any");
  EXPECT_EQ(refusal({.dimension = 2, .keep = DuplicatePolicy::last, .heights = false}), "");
}

}  // namespace
}  // namespace tessera
