// Regions of clouds in memory: right for random ones, and what is asked for is what is read.
#include "src/result/region/regions.h"

#include <gtest/gtest.h>

#include <span>
#include <stop_token>

#include "src/base/option.h"
#include "src/geometry/reference/clouds.h"
#include "src/geometry/reference/reference.h"
#include "tests/region/memory_units.h"
#include "tests/region/region_case.h"

namespace tessera::testing_region {
namespace {

class RandomRegions : public testing::TestWithParam<std::uint64_t> {};

TEST_P(RandomRegions, AreTheRestrictionOfTheWholeTriangulation) {
  std::uint64_t regions = 0, unread = 0;
  for (std::uint64_t seed = 1000 * GetParam(); seed < 1000 * GetParam() + 30; ++seed)
    ASSERT_EQ(check_case(seed, regions, unread), "") << "seed " << seed;
  EXPECT_GT(unread, regions / 10) << "else nothing was proved about what is not read";
}

INSTANTIATE_TEST_SUITE_P(Seeds, RandomRegions, testing::Range<std::uint64_t>(1, 9));

std::vector<LocalPoint> lattice(int side) {
  std::vector<LocalPoint> points;
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) points.push_back({{double(x), double(y), 0}, PointId{points.size()}});
  return points;
}

// A point on the circle of a cell decides how the tie is broken: a unit whose box only touches the circle is read, also
// when there is nothing where it does.
TEST(Regions, ReadsAUnitWhoseBoxTouchesACircle) {
  const Box left{{0, 0.25, 0}, {0.25, 0.5, 0}};
  for (const bool touches : {true, false}) {
    // Three points on a circle around (2.5, 2.5) that goes through (5, 5).
    std::vector<MemoryUnits::Unit> units(2);
    for (const Point& p : {Point{0, 0}, Point{0, 5}, Point{5, 0}}) {
      units[0].points.push_back({p, PointId{units[0].points.size()}});
      units[0].bounds.add(p);
    }
    units[1].points.push_back({{9, 9}, PointId{3}});
    units[1].bounds.add(touches ? Point{5, 5} : Point{5.0001, 5});
    units[1].bounds.add(Point{9, 9});
    auto memory = std::make_unique<MemoryUnits>(units);
    const auto* source = memory.get();
    Regions cloud(std::move(memory), 2, 0);
    ASSERT_FALSE(cloud.ask(left, {}).has_error());
    EXPECT_EQ(source->read_units().size(), touches ? 2u : 1u);
  }
}

// What no cell of the region can hear of stays unread, though it is large.
TEST(Regions, ReadsWhatItNeeds) {
  auto memory = octree_units(make_cloud("uniform", 2, 4000, 5), 2, 30, 1);
  const auto* source = memory.get();
  Regions cloud(std::move(memory), 2, 0);
  const auto answer = cloud.ask(Box{{0.4, 0.4, 0}, {0.5, 0.5, 0}}, {});
  ASSERT_FALSE(answer.has_error()) << answer.error().where;
  const auto& figures = answer.value().figures;
  EXPECT_EQ(figures.points, 4000u);
  EXPECT_EQ(figures.units_read, source->read_units().size());
  EXPECT_LT(figures.points_read, 800u);
  EXPECT_GT(figures.rounds, 1u);
  const auto again = cloud.ask(Box{{0.42, 0.42, 0}, {0.43, 0.43, 0}}, {});
  EXPECT_EQ(again.value().figures.units_read, 0u) << "what was read is there";
  cloud.forget();
  EXPECT_GT(cloud.ask(Box{{0.42, 0.42, 0}, {0.43, 0.43, 0}}, {}).value().figures.units_read, 0u);
}

TEST(Regions, StopsWhileItJudgesCells) {
  auto memory = octree_units(make_cloud("uniform", 2, 4000, 5), 2, 30, 1);
  const auto* source = memory.get();
  Regions cloud(std::move(memory), 2, 0);
  std::stop_source stop;
  const RegionShape shape = [&](std::span<const Point>) {
    if (!source->read_units().empty())
      stop.request_stop();  // all are read: of them no more is asked than this judgement
    return true;
  };
  const auto answer = cloud.ask(Box{{-1, -1, 0}, {2, 2, 0}}, {}, stop.get_token(), shape);
  ASSERT_TRUE(answer.has_error());
  EXPECT_EQ(answer.error().code, Errc::interrupted);
}

TEST(Regions, SaysWhatIsNeededWhenALimitDoesNotSuffice) {
  Regions cloud(octree_units(make_cloud("uniform", 3, 2000, 5), 3, 30, 1), 3, 0);
  const Box region{{0.4, 0.4, 0.4}, {0.5, 0.5, 0.5}};
  const auto answer = cloud.ask(region, {.max_points = 100});
  ASSERT_TRUE(answer.has_error());
  EXPECT_EQ(answer.error().code, Errc::memory);
  const auto sentence = in_plain_words(answer.error().where);
  EXPECT_NE(sentence.find("more than max-points allows"), std::string::npos) << sentence;
  EXPECT_NE(sentence.find("more units are needed: unit "), std::string::npos) << sentence;
  const auto memory = cloud.ask(region, {.memory_bytes = 1000});
  ASSERT_TRUE(memory.has_error());
  EXPECT_NE(in_plain_words(memory.error().where).find("more than memory allows: 0 points of 0 units"),
            std::string::npos);
  const auto late = cloud.ask(region, {.max_seconds = -1});
  ASSERT_TRUE(late.has_error());
  EXPECT_NE(in_plain_words(late.error().where).find("more than max-seconds allows"), std::string::npos);
  const auto part = cloud.ask(region, {.max_points = 100, .partial = true});
  ASSERT_FALSE(part.has_error());
  EXPECT_FALSE(part.value().complete);
  EXPECT_NE(part.value().needed, "");
}

TEST(Regions, RefusesACloudInOnePlane) {
  std::vector<LocalPoint> points = lattice(6);
  Regions cloud(octree_units(points, 3, 4, 1), 3, 0);
  const auto answer = cloud.ask(Box{{1, 1, 0}, {2, 2, 0}}, {});
  ASSERT_TRUE(answer.has_error());
  EXPECT_EQ(answer.error().code, Errc::bad_input);
}

TEST(Regions, BesideAllPointsHasNoCells) {
  Regions cloud(octree_units(make_cloud("uniform", 3, 200, 5), 3, 30, 1), 3, 0);
  const auto answer = cloud.ask(Box{{5, 5, 5}, {6, 6, 6}}, {});
  ASSERT_FALSE(answer.has_error());
  EXPECT_TRUE(answer.value().complete);
  EXPECT_TRUE(answer.value().mesh.cells.empty());
  EXPECT_EQ(answer.value().figures.units_read, 0u);
}

// Neighbours in the mesh are neighbours in the triangulation, in both directions; -1 is the hull.
TEST(Regions, TellsNeighboursAndTheHull) {
  const auto points = lattice(8);
  Regions cloud(octree_units(points, 2, 4, 1), 2, 0);
  const auto whole = cloud.ask(Box{}, {}).value().mesh;
  EXPECT_EQ(whole.ids.size(), 64u);
  EXPECT_EQ(std::count(whole.neighbors.begin(), whole.neighbors.end(), -1), 28);
  EXPECT_EQ(std::count(whole.neighbors.begin(), whole.neighbors.end(), -2), 0);
  const auto part = cloud.ask(Box{{0, 3.25, 0}, {1.5, 3.75, 0}}, {}).value().mesh;
  EXPECT_GT(std::count(part.neighbors.begin(), part.neighbors.end(), -2), 0);
  EXPECT_EQ(std::count(part.neighbors.begin(), part.neighbors.end(), -1), 1) << "x = 0 between y = 3 and 4";
  for (std::size_t i = 0; i < part.neighbors.size(); ++i) {
    if (part.neighbors[i] < 0) continue;
    const auto back = part.neighbors.begin() + 3 * part.neighbors[i];
    EXPECT_EQ(std::count(back, back + 3, static_cast<std::int32_t>(i / 3)), 1);
  }
}

}  // namespace
}  // namespace tessera::testing_region
