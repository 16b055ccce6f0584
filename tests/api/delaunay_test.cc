#include "tessera/delaunay.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <set>
#include <thread>
#include <tuple>

#include "src/geometry/predicates/exact/predicates.h"
#include "tests/api/api_testing.h"

namespace tessera {
namespace {

using testing::cloud;
using testing::failure_of;

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

Point point_of(std::span<const double> coordinates, int dimension, std::size_t i) {
  const double* p = &coordinates[i * static_cast<std::size_t>(dimension)];
  return {p[0], p[1], dimension == 3 ? p[2] : 0};
}

int orientation(const std::array<Point, 4>& p, int dimension) {
  return dimension == 3 ? exact::orientation_3(p[0], p[1], p[2], p[3]) : exact::orientation_2(p[0], p[1], p[2]);
}

std::array<Point, 4> corners_of(const Delaunay& t, std::size_t simplex) {
  const auto corners = static_cast<std::size_t>(t.dimension()) + 1;
  std::array<Point, 4> p{};
  for (std::size_t i = 0; i < corners; ++i) {
    p[i] = point_of(t.points(), t.dimension(), static_cast<std::size_t>(t.simplices()[simplex * corners + i]));
  }
  return p;
}

bool holds(const Delaunay& t, std::size_t simplex, const Point& q) {
  const auto p = corners_of(t, simplex);
  for (int i = 0; i <= t.dimension(); ++i) {
    auto with_q = p;
    with_q[static_cast<std::size_t>(i)] = q;
    if (orientation(with_q, t.dimension()) < 0) return false;
  }
  return true;
}

class DelaunayOf : public ::testing::TestWithParam<std::tuple<std::string, int, int>> {
 protected:
  int dimension() const { return std::get<1>(GetParam()); }
  std::vector<double> points() const {
    return cloud(std::get<0>(GetParam()), dimension(), static_cast<std::size_t>(std::get<2>(GetParam())));
  }
};

TEST_P(DelaunayOf, EqualsCgal) {
  const auto coordinates = points();
  const Delaunay t(coordinates, dimension());
  EXPECT_EQ(difference(testing::expected_cells(coordinates, dimension()), testing::cells_of(t)), "");
}

TEST_P(DelaunayOf, SimplicesArePositiveAndNeighborsAreMutualAcrossTheFacetTheyShare) {
  const Delaunay t(points(), dimension());
  const auto corners = static_cast<std::size_t>(dimension()) + 1;
  const auto simplices = t.simplices(), neighbors = t.neighbors();
  ASSERT_EQ(simplices.size(), neighbors.size());
  const auto facet = [&](std::size_t cell, std::size_t opposite) {
    std::set<std::int32_t> vertices;
    for (std::size_t i = 0; i < corners; ++i) {
      if (i != opposite) vertices.insert(simplices[cell * corners + i]);
    }
    return vertices;
  };
  std::set<std::set<std::int32_t>> hull;
  for (std::size_t c = 0; c * corners < simplices.size(); ++c) {
    EXPECT_GT(orientation(corners_of(t, c), dimension()), 0);
    for (std::size_t i = 0; i < corners; ++i) {
      const auto n = neighbors[c * corners + i];
      if (n < 0) {
        EXPECT_EQ(n, -1);
        EXPECT_TRUE(hull.insert(facet(c, i)).second) << "a facet is outside twice";
        continue;
      }
      const auto* back = &neighbors[static_cast<std::size_t>(n) * corners];
      const auto k = static_cast<std::size_t>(std::find(back, back + corners, static_cast<std::int32_t>(c)) - back);
      ASSERT_LT(k, corners);
      EXPECT_EQ(facet(c, i), facet(static_cast<std::size_t>(n), k));
    }
  }
  EXPECT_GT(hull.size(), static_cast<std::size_t>(dimension()));
}

// Queries where they are hardest: on vertices, edges, facets, the hull and its planes beyond it, and far away.
std::vector<double> nasty_queries(const Delaunay& t, std::size_t wanted) {
  std::mt19937_64 random(5);
  const int d = t.dimension();
  const auto points = t.points();
  const std::size_t n = points.size() / static_cast<std::size_t>(d);
  const auto pick = [&] { return point_of(points, d, random() % n); };
  const auto corners = static_cast<std::size_t>(d) + 1;
  const std::size_t cells = t.simplices().size() / corners;
  std::vector<double> queries;
  const auto add = [&](const Point& q) {
    for (int axis = 0; axis < d; ++axis) queries.push_back(q[axis]);
  };
  const auto mix = [](const Point& a, const Point& b, double w) {
    return Point{a.x + (b.x - a.x) * w, a.y + (b.y - a.y) * w, a.z + (b.z - a.z) * w};
  };
  while (queries.size() < wanted * static_cast<std::size_t>(d)) {
    const auto p = corners_of(t, random() % cells);
    add(pick());
    add(mix(p[0], p[1], 0.5));
    add(mix(mix(p[0], p[1], 0.5), p[2], 0.25));
    add(mix(p[0], p[1], 2));
    add(mix(pick(), pick(), 0.5));
    add(mix(pick(), pick(), -0.5));
    add(mix(pick(), pick(), 1e9));
    add({-0.0, nan, 0});
    add({infinity, 0, 0});
    add({1e308, -1e308, 1e308});
  }
  return queries;
}

TEST_P(DelaunayOf, FindSimplexAgreesWithTryingAllSimplices) {
  const Delaunay t(points(), dimension());
  const auto queries = nasty_queries(t, 300);
  const auto d = static_cast<std::size_t>(dimension());
  std::vector<std::int32_t> found(queries.size() / d);
  t.find_simplex(queries, found);
  const std::size_t cells = t.simplices().size() / (d + 1);
  for (std::size_t i = 0; i < found.size(); ++i) {
    const Point q = point_of(queries, dimension(), i);
    bool anywhere = false;
    for (std::size_t c = 0; is_finite(q) && c < cells && !anywhere; ++c) anywhere = holds(t, c, q);
    ASSERT_EQ(found[i] >= 0, anywhere) << "query " << i << ": " << q.x << " " << q.y << " " << q.z;
    if (anywhere) {
      EXPECT_TRUE(holds(t, static_cast<std::size_t>(found[i]), q)) << "query " << i;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Clouds, DelaunayOf,
                         ::testing::Combine(::testing::ValuesIn(cloud_kinds()), ::testing::Values(2, 3),
                                            ::testing::Values(5, 60, 500)));

TEST(Delaunay, EqualPointsAreTheVertexOfTheFirst) {
  const std::vector<double> points{0, 0, 1, 0, 0, 1, 1, 0, -0.0, 0.0, 1, 0};
  const Delaunay t(points, 2);
  EXPECT_EQ(t.simplices().size(), 3u);
  const std::vector<std::pair<std::int32_t, std::int32_t>> expected{{3, 1}, {4, 0}, {5, 1}};
  EXPECT_EQ(std::vector(t.duplicates().begin(), t.duplicates().end()), expected);
  for (const auto v : t.simplices()) EXPECT_LT(v, 3);
  EXPECT_EQ(std::vector(t.points().begin(), t.points().end()), points);
}

TEST(Delaunay, TheInputMayGoAndTheTriangulationMayMove) {
  auto points = std::make_unique<std::vector<double>>(cloud("uniform", 3, 200));
  auto expected = testing::expected_cells(*points, 3);
  Delaunay t(*points, 3);
  points.reset();
  Delaunay moved = std::move(t);
  EXPECT_EQ(testing::cells_of(moved), expected);
  std::vector<std::int32_t> found(1);
  moved.find_simplex(std::vector{0.5, 0.5, 0.5}, found);
  EXPECT_GE(found[0], 0);
}

TEST(Delaunay, FindSimplexMayBeAskedFromSeveralThreadsAtOnce) {
  const Delaunay t(cloud("lattice", 3, 3000), 3);
  const auto queries = nasty_queries(t, 2000);
  std::vector<std::int32_t> expected(queries.size() / 3);
  t.find_simplex(queries, expected);
  std::vector<std::vector<std::int32_t>> found(4, expected);
  {
    std::vector<std::jthread> threads;
    for (auto& each : found) threads.emplace_back([&] { t.find_simplex(queries, each); });
  }
  for (const auto& each : found) EXPECT_EQ(each, expected);
}

TEST(Delaunay, WhatCannotBeTriangulatedIsRefusedWithASentence) {
  const auto expect = [](std::vector<double> points, int dimension, Cause cause, const std::string& sentence) {
    const auto failure = failure_of([&] { Delaunay(points, dimension); });
    EXPECT_EQ(failure.cause(), cause);
    EXPECT_EQ(failure.what(), sentence);
  };
  expect({0, 0, 0}, 4, Cause::usage, "dimension: must be 2 or 3");
  expect({0, 0, 0, 1}, 3, Cause::usage, "the array: its length, 4, is not a multiple of the dimension, 3");
  expect({}, 2, Cause::bad_input, "the array: there are no points");
  expect({0, 0, 1, 1}, 2, Cause::bad_input, "the array: there are 2 points; a 2D triangulation needs at least 3");
  expect({1, 2, 1, 2, 1, 2, 1, 2}, 2, Cause::bad_input, "the array: all 4 points are identical");
  expect({0, 0, 1, 1, 2, 2, 3, 3}, 2, Cause::bad_input,
         "the array: all 4 points lie on one line; a 2D triangulation needs points off it");
  expect({0, 0, 5, 1, 0, 5, 0, 1, 5, 1, 1, 5, 3, 4, 5}, 3, Cause::bad_input,
         "the array: all 5 points lie in one plane; a 3D triangulation needs points off it");
  expect({0, 0, 0, 1, 0, 0, 1, nan, 0, 0, 0, 1}, 3, Cause::bad_input, "the array, row 2: y is nan");
  expect({0, 0, -infinity, 0, 1, 0}, 2, Cause::bad_input, "the array, row 1: x is -infinite");
  const Delaunay t(std::vector<double>{0, 0, 1, 0, 0, 1}, 2);
  std::vector<std::int32_t> out(2);
  EXPECT_EQ(failure_of([&] { t.find_simplex(std::vector{0.1, 0.1}, out); }).cause(), Cause::usage);
}

TEST(Delaunay, StopsSoonAfterItIsAsked) {
  const auto points = cloud("uniform", 3, 20'000);
  std::stop_source stop;
  stop.request_stop();
  const auto failure = failure_of([&] { Delaunay(points, 3, stop.get_token()); });
  EXPECT_EQ(failure.cause(), Cause::interrupted);
  EXPECT_STREQ(failure.what(), "stopped, as was requested");
}

TEST(RestoredDelaunay, IsTheOneThatWasThere) {
  for (const int dimension : {2, 3}) {
    auto points = testing::cloud("lattice", dimension, 300);
    points.insert(points.end(), points.begin(), points.begin() + 3 * dimension);
    const Delaunay made(points, dimension);
    const auto again =
        Delaunay::restore(made.points(), dimension, made.simplices(), made.neighbors(), made.duplicates());
    EXPECT_EQ(testing::cells_of(again), testing::cells_of(made));
    EXPECT_EQ(again.duplicates().size(), 3u);
    std::vector<std::int32_t> expected(points.size() / static_cast<std::size_t>(dimension)), found(expected.size());
    made.find_simplex(points, expected);
    again.find_simplex(points, found);
    EXPECT_EQ(found, expected);
    const auto refused = testing::failure_of([&] {
      Delaunay::restore(made.points().first(made.points().size() / 2), dimension, made.simplices(), made.neighbors(),
                        {});
    });
    EXPECT_EQ(refused.cause(), Cause::usage) << "it has vertices that are no points";
  }
}

}  // namespace
}  // namespace tessera
