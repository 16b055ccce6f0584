// Points on both sides of a thin slab whose middle is frozen: every walk from one side to the other runs into the hole.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <ctime>
#include <limits>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "src/tiling/tile/circumsphere.h"
#include "tests/kernel/kernel_testing.h"

namespace tessera::testing {
namespace {

// 1 long (and wide in 3D) and `height` high, which is z or, in 2D, y.
struct Slab {
  int dimension;
  std::size_t n;
  double height;
  std::vector<Point> points, above_or_below;
  Box box;  // ends with the slab where it is thin, and far out else

  Slab(int d, std::size_t count, double h) : dimension(d), n(count), height(h) {
    std::mt19937_64 random(11);
    std::uniform_real_distribution<double> unit(0, 1);
    const auto point = [&](double up) {
      const double x = unit(random);
      return d == 3 ? Point{x, unit(random), up} : Point{x, up, 0};
    };
    for (std::size_t i = 0; i < n; ++i) points.push_back(point(h * unit(random)));
    std::sort(points.begin(), points.end());
    const double apart = std::pow(h / static_cast<double>(n), 1.0 / d);
    for (int i = 0; i < 1000; ++i) {
      const double out = apart * (0.01 + unit(random));
      above_or_below.push_back(point(random() % 2 ? -out : h + out));
    }
    constexpr double far = std::numeric_limits<double>::max() / 4;
    box = {{-10, d == 3 ? -10.0 : 0, d == 3 ? 0 : -far}, {10, d == 3 ? 10 : h, d == 3 ? h : far}};
  }
  std::unique_ptr<Kernel> built(KernelKind kind) const {
    auto kernel = make_kernel(dimension, kind);
    kernel->build(points);
    return kernel;
  }
  // How many cells were frozen.
  std::size_t freeze(Kernel& kernel) const {
    const auto at = [&](Vertex v) { return kernel.point(v); };
    const FinalCells frozen = kernel.freeze([&](const Vertex* v) {
      const Ball ball = dimension == 3 ? circumsphere(at(v[0]), at(v[1]), at(v[2]), at(v[3]))
                                       : circumcircle(at(v[0]), at(v[1]), at(v[2]));
      return surely_inside(ball, box, dimension);
    });
    return frozen.rows.size();
  }
};

double seconds_to_insert(Kernel& kernel, const std::vector<Point>& points) {
  const auto now = [] {
    timespec used{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &used);
    return static_cast<double>(used.tv_sec) + 1e-9 * static_cast<double>(used.tv_nsec);
  };
  const double begin = now();
  std::vector<Vertex> around;
  for (const Point& p : points) kernel.insert(p, false, InsertMode::if_local_neighbour, around);
  return now() - begin;
}

// Without a hole the walk goes through the slab and along it; around the hole it may not take longer than that.
TEST(Hole, TheWayAroundItIsNoLongerThanTheWayThrough) {
  const Slab slab(3, 60000, 0.05);
  const auto frozen = slab.built(KernelKind::flat), whole = slab.built(KernelKind::flat);
  ASSERT_GT(slab.freeze(*frozen), 100000u);
  const double around_s = seconds_to_insert(*frozen, slab.above_or_below);
  EXPECT_LT(around_s, 2 * seconds_to_insert(*whole, slab.above_or_below));
}

class HoleIn : public ::testing::TestWithParam<int> {};

TEST_P(HoleIn, PointsOnBothSidesAreFoundAndInsertedAsByCgal) {
  const Slab slab(GetParam(), GetParam() == 3 ? 5000 : 2000, GetParam() == 3 ? 0.1 : 0.01);
  const auto flat = slab.built(KernelKind::flat), cgal = slab.built(KernelKind::cgal);
  ASSERT_GT(slab.freeze(*flat), 1000u);
  std::vector<Vertex> around, expected;
  for (int pass = 0; pass < 2; ++pass) {  // all of them are there the second time, or refused again
    for (const Point& p : slab.above_or_below) {
      const Insertion made = flat->insert(p, false, InsertMode::if_local_neighbour, around);
      const Insertion reference = cgal->insert(p, false, InsertMode::if_local_neighbour, expected);
      ASSERT_EQ(std::pair(made.vertex, made.inserted), std::pair(reference.vertex, reference.inserted));
      std::sort(around.begin(), around.end());
      std::sort(expected.begin(), expected.end());
      ASSERT_EQ(around, expected);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Kernel, HoleIn, ::testing::Values(2, 3),
                         [](const auto& info) { return std::to_string(info.param) + "D"; });

}  // namespace
}  // namespace tessera::testing
