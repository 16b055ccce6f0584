// Answers do not depend on what other code has done to the arithmetic of the thread that asks.
#include <gtest/gtest.h>

#include <bit>
#include <cfenv>
#include <cmath>
#include <functional>

#ifdef __SSE__
#include <immintrin.h>
#endif

#include "tests/api/api_testing.h"
#include "tests/api/temporary_home.h"

namespace tessera {
namespace {

using testing::cells_of;
using testing::TemporaryHome;

// Some integers times 2^-1022: the differences of points are under the smallest normal number.
std::vector<double> smallest(int dimension) {
  auto points = testing::cloud("uniform", dimension, 1500);
  for (double& x : points) x = std::ldexp(std::floor(std::ldexp(x, 40)), -1022 - 40);
  return points;
}

struct Setting {
  const char* name;
  std::function<void()> set;
};

void PrintTo(const Setting& setting, std::ostream* out) { *out << setting.name; }

class Arithmetic : public ::testing::TestWithParam<Setting> {
 protected:
  void SetUp() override { std::fegetenv(&before_); }
  void TearDown() override { std::fesetenv(&before_); }
  std::fenv_t before_;
};

TEST_P(Arithmetic, OfTheCallerChangesNoAnswerAndIsLeftAsItWas) {
  const TemporaryHome home;
  for (const int dimension : {2, 3}) {
    const auto points = smallest(dimension);
    const Delaunay expected(points, dimension);
    std::vector<std::int32_t> found(expected.simplices().size() / (static_cast<std::size_t>(dimension) + 1));
    std::vector<double> queries;  // a corner of each simplex, moved by the least
    for (std::size_t s = 0; s < found.size(); ++s) {
      const auto corner = static_cast<std::size_t>(expected.simplices()[s * (static_cast<std::size_t>(dimension) + 1)]);
      for (int axis = 0; axis < dimension; ++axis) {
        const double x = points[corner * static_cast<std::size_t>(dimension) + static_cast<std::size_t>(axis)];
        queries.push_back(std::nextafter(x, std::ldexp(0.5, -1022)));
      }
    }
    auto expected_found = found;
    expected.find_simplex(queries, expected_found);
    const auto expected_cells = cells_of(expected);
    TriangulationOptions options;
    options.dimension(dimension);
    options.max_points_per_tile(200);
    options.threads(2);
    int told = 0;
    options.progress([&](const JobProgress&) { GetParam().set(), ++told; });

    GetParam().set();
    std::fenv_t set;
    std::fegetenv(&set);
    const Delaunay whole(points, dimension);
    whole.find_simplex(queries, found);
    const auto t = triangulate(points, options);
    const auto many = cells_of(t);
    const int rounding = std::fegetround();
#ifdef __SSE__
    const auto control = _mm_getcsr() & ~0x3Fu;  // but for the flags of what has happened
#endif
    std::fesetenv(&before_);

    EXPECT_EQ(cells_of(whole), expected_cells);
    EXPECT_EQ(found, expected_found);
    EXPECT_EQ(difference(expected_cells, many), "");
    EXPECT_GT(told, 0);
    std::fesetenv(&set);
    EXPECT_EQ(std::fegetround(), rounding);
#ifdef __SSE__
    EXPECT_EQ(_mm_getcsr() & ~0x3Fu, control);
#endif
    std::fesetenv(&before_);
  }
}

std::vector<Setting> settings() {
  return {
#ifdef __SSE__
      {"flush_to_zero", [] { _mm_setcsr(_mm_getcsr() | 0x8040); }},
      {"traps", [] { _mm_setcsr(_mm_getcsr() & ~0x1FBFu); }},
#endif
      {"upward", [] { std::fesetround(FE_UPWARD); }}};
}

INSTANTIATE_TEST_SUITE_P(Settings, Arithmetic, ::testing::ValuesIn(settings()),
                         [](const auto& each) { return each.param.name; });

}  // namespace
}  // namespace tessera
