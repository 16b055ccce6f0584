#include "src/tiling/hilbert.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <utility>
#include <vector>

#include "tests/tiling/clouds.h"

namespace tessera {
namespace {

// The cell centres of a full grid of 2^k cells an axis, in the order of the curve.
std::vector<Point> along_the_curve(int dimension, int k) {
  const int n = 1 << k;
  const double side = n;
  const HilbertKey key({{0, 0, 0}, {side, side, dimension == 2 ? 0 : side}}, dimension);
  std::vector<std::pair<std::uint64_t, Point>> cells;
  for (int x = 0; x < n; ++x) {
    for (int y = 0; y < n; ++y) {
      for (int z = 0; z < (dimension == 2 ? 1 : n); ++z) {
        const Point p{x + 0.5, y + 0.5, dimension == 2 ? 0 : z + 0.5};
        cells.emplace_back(key(p), p);
      }
    }
  }
  std::sort(cells.begin(), cells.end());
  std::vector<Point> points;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    EXPECT_TRUE(i == 0 || cells[i].first != cells[i - 1].first);
    points.push_back(cells[i].second);
  }
  return points;
}

class FullGrid : public testing::TestWithParam<std::pair<int, int>> {};

TEST_P(FullGrid, IsVisitedFromFaceToFace) {
  const auto [dimension, k] = GetParam();
  const auto points = along_the_curve(dimension, k);
  ASSERT_EQ(points.size(), std::size_t{1} << (dimension * k));
  for (std::size_t i = 1; i < points.size(); ++i) {
    const Point& a = points[i - 1];
    const Point& b = points[i];
    ASSERT_EQ(std::abs(a.x - b.x) + std::abs(a.y - b.y) + std::abs(a.z - b.z), 1.0) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(, FullGrid,
                         testing::Values(std::pair{2, 1}, std::pair{2, 5}, std::pair{2, 9}, std::pair{3, 1},
                                         std::pair{3, 2}, std::pair{3, 4}, std::pair{3, 6}));

TEST(Hilbert, ResolvesTheLastBitOfItsGrid) {
  for (const int dimension : {2, 3}) {
    const double side = std::ldexp(1, dimension == 2 ? 31 : 21);
    const HilbertKey key({{0, 0, 0}, {side, side, side}}, dimension);
    const Point a{12345.5, 6789.5, 4321.5};
    for (int axis = 0; axis < dimension; ++axis) {
      Point b = a;
      b[axis] += 1;
      EXPECT_NE(key(a), key(b));
      b[axis] -= 0.75;
      EXPECT_EQ(key(a), key(b));
    }
    EXPECT_LT(key({side, side, side}), std::uint64_t{1} << 63);
  }
}

TEST(Hilbert, ClampsPointsOutside) {
  const HilbertKey key({{0, 0, 0}, {1, 1, 1}}, 3);
  EXPECT_EQ(key({-5, -5, -5}), key({0, 0, 0}));
  EXPECT_EQ(key({5, 0.5, 1e300}), key({1, 0.5, 1}));
}

TEST(Hilbert, TellsPointsApartInTheSmallestAndLargestBoxes) {
  constexpr double most = std::numeric_limits<double>::max();
  constexpr double least = std::numeric_limits<double>::denorm_min();
  for (const double side : {most, 1e300, 1e-300, 2 * least}) {
    for (const int dimension : {2, 3}) {
      const HilbertKey key({{-side, -side, dimension == 2 ? 0 : -side}, {side, side, dimension == 2 ? 0 : side}},
                           dimension);
      EXPECT_NE(key({-side, -side, 0}), key({side, -side, 0})) << side;
      EXPECT_NE(key({-side, -side, 0}), key({0, 0, 0})) << side;
    }
  }
  const HilbertKey flat_and_far({{0, 1e308, 0}, {least, 1e308, least}}, 3);
  EXPECT_NE(flat_and_far({0, 1e308, 0}), flat_and_far({least, 1e308, 0}));
  EXPECT_EQ(HilbertKey(Bounds{}, 3)({1, 2, 3}), HilbertKey(Bounds{}, 3)({4, 5, 6}));
}

}  // namespace
}  // namespace tessera
