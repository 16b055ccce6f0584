// One point whose conflict zone is nearly the whole triangulation: the centre of points close to a sphere. It may cost
// what its zone costs, once; nothing after it.
#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <memory>
#include <random>
#include <span>
#include <vector>

#include "tests/kernel/kernel_testing.h"

namespace tessera::testing {
namespace {

// Near the unit sphere, which none of them is exactly on, so that all of its inside is a maze of long cells; in 2D near
// the unit circle. `spread` 1 is all of it, less is a cap, where walks are short.
std::vector<Point> round_cloud(int dimension, std::size_t n, double spread) {
  std::mt19937_64 random(n);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> noise(-1e-6, 1e-6);
  std::vector<Point> points;
  while (points.size() < n) {
    const double x = normal(random) + 1 / spread - 1, y = normal(random), z = dimension == 3 ? normal(random) : 0;
    const double scale = (1 + noise(random)) / std::sqrt(x * x + y * y + z * z);
    points.push_back({x * scale, y * scale, z * scale});
  }
  return points;
}

double seconds_of_this_thread() {
  timespec used{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &used);
  return static_cast<double>(used.tv_sec) + 1e-9 * static_cast<double>(used.tv_nsec);
}

std::size_t on_the_heap() {
  const auto used = mallinfo2();
  return used.uordblks + used.hblkhd;
}

class LargeZone : public ::testing::TestWithParam<int> {
 protected:
  static constexpr std::size_t first = 30000, then = 3000;
  static constexpr Point centre{1e-9, 2e-9, 0};

  std::span<const Point> beginning() const { return beginning_; }
  std::span<const Point> rest() const { return rest_; }
  std::unique_ptr<Kernel> with_centre_last() const {
    auto kernel = make_kernel(GetParam());
    kernel->build(beginning());
    insert(*kernel, {&centre, 1});
    return kernel;
  }
  static void insert(Kernel& kernel, std::span<const Point> points) {
    std::vector<Vertex> around;
    for (const Point& p : points) ASSERT_TRUE(kernel.insert(p, false, InsertMode::always, around).inserted);
  }
  std::vector<Point> beginning_ = round_cloud(GetParam(), first, 1), rest_ = round_cloud(GetParam(), then, 0.03);
};

// The same triangulation is made in two orders; in the other one nothing is left of the large zone.
TEST_P(LargeZone, WhatIsInsertedAfterOneCostsWhatItWouldWithoutIt) {
  const auto seconds = [&](Kernel& kernel) {
    const double begin = seconds_of_this_thread();
    insert(kernel, rest());
    return seconds_of_this_thread() - begin;
  };
  double after = 1e9, otherwise = 1e9;  // the least of several: others use this processor too
  for (int round = 0; round < 3; ++round) {
    after = std::min(after, seconds(*with_centre_last()));
    const auto built = make_kernel(GetParam());
    std::vector<Point> all(beginning().begin(), beginning().end());
    all.push_back(centre);
    built->build(all);
    otherwise = std::min(otherwise, seconds(*built));
  }
  EXPECT_LT(after, 3 * otherwise);
}

// The budget asks memory(), and plans with 700 bytes a point in 3D and 260 in 2D.
TEST_P(LargeZone, ItTakesNoMoreThanIsPlannedAndTellsAllOfIt) {
  auto kernel = make_kernel(GetParam());
  kernel->build(beginning());
  const std::size_t before = kernel->memory(), heap_before = on_the_heap();
  insert(*kernel, {&centre, 1});
  const std::size_t heap = on_the_heap() - heap_before, told = kernel->memory();
  EXPECT_LT(told, (GetParam() == 3 ? 700 : 260) * first);
  if (heap_before == 0) GTEST_SKIP() << "the sanitizer's heap does not tell its size";
  EXPECT_GE(101 * (told - before), 100 * heap);  // what malloc adds
}

TEST_P(LargeZone, ItsScratchIsGivenBackSoonAfter) {
  const auto kernel = with_centre_last();
  insert(*kernel, rest());
  const auto fresh = make_kernel(GetParam());
  ASSERT_TRUE(fresh->load(kernel->save()));
  EXPECT_LT(kernel->memory(), 3 * fresh->memory() / 2);
}

TEST_P(LargeZone, ABuildEndsWithoutItsScratch) {
  auto kernel = make_kernel(GetParam());
  std::vector<Point> all(beginning().begin(), beginning().end());
  all.insert(all.begin() + first / 2, centre);
  kernel->build(all);
  const auto fresh = make_kernel(GetParam());
  ASSERT_TRUE(fresh->load(kernel->save()));
  EXPECT_LT(kernel->memory(), 5 * fresh->memory() / 4);
}

TEST_P(LargeZone, TheTriangulationAfterOneIsThatOfItsPoints) {
  const auto kernel = with_centre_last();
  insert(*kernel, rest().first(200));
  const auto cgal = make_kernel(GetParam(), KernelKind::cgal);
  std::vector<Point> all(beginning().begin(), beginning().end());
  all.push_back(centre);
  all.insert(all.end(), rest().begin(), rest().begin() + 200);
  cgal->build(all);
  EXPECT_EQ(difference(cells_of(*cgal), cells_of(*kernel)), "");
  EXPECT_EQ(wrong_with(*kernel), "");
}

INSTANTIATE_TEST_SUITE_P(Kernel, LargeZone, ::testing::Values(2, 3),
                         [](const auto& info) { return "in" + std::to_string(info.param) + "D"; });

}  // namespace
}  // namespace tessera::testing
