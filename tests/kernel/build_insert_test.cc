// Building and inserting: equal point sets give equal cells, whatever the order.
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <stop_token>
#include <vector>

#include "src/base/stopped.h"
#include "src/geometry/reference/clouds.h"
#include "tests/kernel/kernel_testing.h"

namespace tessera::testing {
namespace {

std::vector<Vertex> sorted(std::vector<Vertex> list) {
  std::sort(list.begin(), list.end());
  return list;
}

bool any_local(const Kernel& kernel, const std::vector<Vertex>& list) {
  return std::any_of(list.begin(), list.end(), [&](Vertex v) { return kernel.is_local(v); });
}

class Spanning : public ::testing::TestWithParam<KernelCloud> {};
class Flat : public ::testing::TestWithParam<KernelCloud> {};

TEST_P(Spanning, BuildGivesTheDelaunayTriangulationWithItsHull) {
  const KernelCloud& cloud = GetParam();
  const auto kernel = built(cloud);
  EXPECT_EQ(kernel->dimension(), cloud.dimension);
  EXPECT_EQ(kernel->max_dimension(), cloud.dimension);
  ASSERT_EQ(kernel->vertices(), cloud.points.size());
  for (Vertex v = 1; v <= kernel->vertices(); ++v) {
    EXPECT_EQ(kernel->point(v), cloud.points[v - 1]);
    EXPECT_TRUE(kernel->is_local(v) && kernel->alive(v));
  }
  EXPECT_EQ(difference(reference(cloud.points, cloud.dimension), cells_of(*kernel)), "");
  EXPECT_EQ(wrong_with(*kernel), "");
  EXPECT_GT(kernel->memory(), cloud.points.size() * sizeof(Point));
}

TEST_P(Spanning, InsertionInAnyOrderEqualsBuilding) {
  const KernelCloud& cloud = GetParam();
  const auto expected = reference(cloud.points, cloud.dimension);
  std::vector<std::size_t> as_given(cloud.points.size());
  std::iota(as_given.begin(), as_given.end(), 0);  // in some clouds flat for long
  std::vector<Vertex> around;
  for (const auto& order : {as_given, shuffled(cloud.points.size(), 1), shuffled(cloud.points.size(), 2)}) {
    const auto kernel = make_kernel(cloud.dimension, cloud.kind);
    std::vector<PointId> ids;
    for (const std::size_t i : order) {
      const Insertion made = kernel->insert(cloud.points[i], i % 2 == 0, InsertMode::always, around);
      ASSERT_TRUE(made.inserted);
      ids.push_back({i});
      ASSERT_EQ(made.vertex, ids.size());
      EXPECT_EQ(kernel->is_local(made.vertex), i % 2 == 0);
    }
    EXPECT_EQ(difference(expected, cells_of(*kernel, ids)), "");
    EXPECT_EQ(wrong_with(*kernel), "");
  }
}

TEST_P(Spanning, InsertionAfterBuildingEqualsBuildingAll) {
  const KernelCloud& cloud = GetParam();
  const auto order = shuffled(cloud.points.size(), 3);
  for (const std::size_t first : {order.size() / 3, order.size() / 2, order.size() - 1}) {
    std::vector<Point> some;
    for (std::size_t k = 0; k < first; ++k) some.push_back(cloud.points[order[k]]);
    const auto kernel = make_kernel(cloud.dimension, cloud.kind);
    kernel->build(some);
    std::vector<Vertex> around;
    for (std::size_t k = first; k < order.size(); ++k) {
      kernel->insert(cloud.points[order[k]], false, InsertMode::always, around);
    }
    EXPECT_EQ(difference(reference(cloud.points, cloud.dimension), cells_of(*kernel, {order.begin(), order.end()})),
              "");
  }
}

TEST_P(Spanning, AroundAreTheNeighboursOfTheNewVertex) {
  const KernelCloud& cloud = GetParam();
  const auto kernel = make_kernel(cloud.dimension, cloud.kind);
  std::vector<Vertex> around, neighbours;
  for (const std::size_t i : shuffled(cloud.points.size(), 4)) {
    const bool flat = kernel->dimension() < cloud.dimension;
    const Insertion made = kernel->insert(cloud.points[i], true, InsertMode::always, around);
    if (flat) {  // everybody else
      EXPECT_EQ(around.size(), kernel->vertices() - 1);
      continue;
    }
    kernel->neighbours(made.vertex, neighbours);
    ASSERT_EQ(sorted(around), sorted(neighbours));
    EXPECT_EQ(std::count(around.begin(), around.end(), infinite_vertex), 0);
  }
}

TEST_P(Spanning, APointIsRefusedExactlyIfItWouldHaveNoLocalNeighbour) {
  const KernelCloud& cloud = GetParam();
  const auto order = shuffled(cloud.points.size(), 5);
  std::vector<Point> locals, others;
  for (const std::size_t i : order) {  // locals on one side: the others seldom touch them
    (locals.size() < order.size() / 4 && cloud.points[i].x <= cloud.points[order[0]].x ? locals : others)
        .push_back(cloud.points[i]);
  }
  const auto kernel = make_kernel(cloud.dimension, cloud.kind);
  kernel->build(locals);
  std::vector<Vertex> around, would_have;
  std::size_t refused = 0, inserted = 0;
  for (std::size_t i = 0; i < others.size(); ++i) {
    if (kernel->dimension() < cloud.dimension) {
      ASSERT_TRUE(kernel->insert(others[i], false, InsertMode::if_local_neighbour, around).inserted);
      continue;
    }
    // Every other foreign point goes in regardless, so that there are foreign neighbourhoods at all.
    const auto copy = copy_of(*kernel, cloud);
    ASSERT_TRUE(copy);
    const Insertion reference = copy->insert(others[i], false, InsertMode::always, would_have);
    copy->neighbours(reference.vertex, would_have);
    if (i % 2 == 0) {
      kernel->insert(others[i], false, InsertMode::always, around);
      continue;
    }
    const auto before = cells_of(*kernel);
    const Insertion made = kernel->insert(others[i], false, InsertMode::if_local_neighbour, around);
    ASSERT_EQ(made.inserted, any_local(*kernel, would_have));
    ASSERT_EQ(sorted(around), sorted(would_have));
    if (!made.inserted) {
      ++refused;
      EXPECT_EQ(made.vertex, 0u);
      ASSERT_EQ(cells_of(*kernel), before);
    } else {
      ++inserted;
    }
  }
  EXPECT_EQ(wrong_with(*kernel), "");
  if (cloud.points.size() > 100) {
    EXPECT_GT(refused + inserted, 10u);
  }
}

TEST_P(Spanning, APointThatIsThereIsNotInsertedAgain) {
  const KernelCloud& cloud = GetParam();
  const auto kernel = built(cloud);
  const auto before = cells_of(*kernel);
  std::vector<Vertex> around;
  for (const InsertMode mode : {InsertMode::always, InsertMode::if_local_neighbour}) {
    for (std::size_t i = 0; i < cloud.points.size(); i += 7) {
      const Insertion made = kernel->insert(cloud.points[i], false, mode, around);
      EXPECT_FALSE(made.inserted);
      EXPECT_EQ(made.vertex, i + 1);
    }
  }
  EXPECT_EQ(kernel->vertices(), cloud.points.size());
  EXPECT_EQ(cells_of(*kernel), before);
}

TEST_P(Spanning, TheStarsOfAllVerticesAreTheCells) {
  const KernelCloud& cloud = GetParam();
  const auto kernel = built(cloud);
  const std::size_t corners = static_cast<std::size_t>(cloud.dimension) + 1;
  std::vector<IdCell> from_stars;
  std::vector<Vertex> star, neighbours;
  for (Vertex v = 1; v <= kernel->vertices(); ++v) {
    kernel->star(v, star);
    std::vector<Vertex> joined;
    for (std::size_t c = 0; c < star.size(); c += corners) {
      IdCell cell{infinite_id, infinite_id, infinite_id, infinite_id};
      for (std::size_t i = 0; i < corners; ++i) {
        const Vertex w = star[c + i];
        if (w == infinite_vertex) continue;
        cell[i] = {w - 1};
        if (w != v) joined.push_back(w);
      }
      std::sort(cell.begin(), cell.end());
      if (cell[0].value == v - 1) from_stars.push_back(cell);  // each cell once: by its least vertex
    }
    std::sort(joined.begin(), joined.end());
    joined.erase(std::unique(joined.begin(), joined.end()), joined.end());
    kernel->neighbours(v, neighbours);
    ASSERT_EQ(joined, sorted(neighbours));
  }
  std::sort(from_stars.begin(), from_stars.end());
  EXPECT_EQ(from_stars, cells_of(*kernel));
}

TEST_P(Flat, BuildingAndInsertingTellTheDimension) {
  const KernelCloud& cloud = GetParam();
  const auto kernel = built(cloud);
  const auto one_by_one = make_kernel(cloud.dimension, cloud.kind);
  std::vector<Vertex> around;
  for (const Point& p : cloud.points) {
    EXPECT_TRUE(one_by_one->insert(p, false, InsertMode::if_local_neighbour, around).inserted);
    EXPECT_EQ(around.size() + 1, one_by_one->vertices());
  }
  const int expected = cloud.name == "line"      ? 1
                       : cloud.points.size() > 3 ? 2
                                                 : static_cast<int>(cloud.points.size()) - 1;
  EXPECT_EQ(kernel->dimension(), expected);
  EXPECT_EQ(one_by_one->dimension(), expected);
  EXPECT_EQ(kernel->vertices(), cloud.points.size());
}

TEST_P(Flat, PointsThatAreThereAreFoundWhileFlat) {
  const KernelCloud& cloud = GetParam();
  const auto kernel = built(cloud);
  std::vector<Vertex> around;
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    const Insertion made = kernel->insert(cloud.points[i], true, InsertMode::always, around);
    EXPECT_FALSE(made.inserted);
    EXPECT_EQ(made.vertex, i + 1);
  }
}

TEST_P(Flat, MorePointsLiftItToTheDelaunayTriangulation) {
  const KernelCloud& cloud = GetParam();
  const auto kernel = built(cloud);
  auto points = cloud.points;
  const double up = cloud.dimension == 3 ? 1 : 0;
  std::vector<Vertex> around;
  for (const Point& p : std::vector<Point>{{2, 3, up}, {9, -4, 5 * up}, {-3, 1, -2 * up}, {2, 4, up}, {1, 3, up}}) {
    kernel->insert(p, true, InsertMode::if_local_neighbour, around);
    points.push_back(p);
  }
  EXPECT_EQ(kernel->dimension(), cloud.dimension);
  EXPECT_EQ(difference(reference(points, cloud.dimension), cells_of(*kernel)), "");
  EXPECT_EQ(wrong_with(*kernel), "");
}

// Points on two skew lines: every segment of one makes a cell with every segment of the other, and a new point is in
// conflict with as many cells as the other line has segments.
TEST(LargeZones, GrowingOnesKeepEveryCell) {
  constexpr std::size_t on_a_line = 1400;
  std::vector<Point> points;
  for (std::size_t i = 0; i < on_a_line; ++i) {
    const double t = static_cast<double>((i * 797) % on_a_line);  // in no order
    points.push_back({t, 0, 0});
    points.push_back({700, t - 700.25, 1000});
  }
  const auto kernel = make_kernel(3, KernelKind::flat);
  kernel->build(points);
  const CellList list = kernel->cells();
  std::size_t finite = 0;
  for (std::size_t c = 0; c < list.vertices.size(); c += 4) {
    finite += std::count(&list.vertices[c], &list.vertices[c] + 4, infinite_vertex) == 0;
  }
  EXPECT_EQ(finite, (on_a_line - 1) * (on_a_line - 1));
}

INSTANTIATE_TEST_SUITE_P(Kernel, Spanning, ::testing::ValuesIn(spanning_clouds()),
                         [](const auto& info) { return name_of_cloud(info.param); });
INSTANTIATE_TEST_SUITE_P(Kernel, Flat, ::testing::ValuesIn(flat_clouds()),
                         [](const auto& info) { return name_of_cloud(info.param); });

TEST(Build, ThatIsAskedToStopThrowsAndCanBeDoneAgain) {
  for (const KernelKind kind : {KernelKind::cgal, KernelKind::flat}) {
    for (const int dimension : {2, 3}) {
      std::vector<Point> points;
      for (const LocalPoint& p : make_cloud("uniform", dimension, 5000, 1)) points.push_back(p.at);
      const auto kernel = make_kernel(dimension, kind);
      std::stop_source stop;
      kernel->build(points, KeepPoints::copied, stop.get_token());
      const auto cells = cells_of(*kernel);
      stop.request_stop();
      EXPECT_THROW(kernel->build(points, KeepPoints::borrowed, stop.get_token()), Stopped);
      kernel->build(points);
      EXPECT_EQ(cells_of(*kernel), cells);
    }
  }
}

}  // namespace
}  // namespace tessera::testing
