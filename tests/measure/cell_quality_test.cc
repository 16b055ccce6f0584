#include "src/result/measure/cell_quality.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

namespace tessera {
namespace {

CellQuality quality(const std::vector<Point>& corners) { return quality_of(corners, volume_times_factorial(corners)); }

const std::vector<Point> regular_triangle{{0, 0, 0}, {1, 0, 0}, {0.5, std::sqrt(0.75), 0}};
const std::vector<Point> regular_tetrahedron{{1, 1, 1}, {-1, 1, -1}, {1, -1, -1}, {-1, -1, 1}};

TEST(CellQuality, OfRegularCellsIsOne) {
  const CellQuality flat = quality(regular_triangle);
  EXPECT_NEAR(flat.radius_ratio, 1, 1e-15);
  EXPECT_NEAR(flat.least_angle, 60, 1e-13);
  EXPECT_NEAR(flat.largest_angle, 60, 1e-13);
  EXPECT_NEAR(flat.circumradius, 1 / std::sqrt(3.0), 1e-15);
  const CellQuality solid = quality(regular_tetrahedron);
  EXPECT_NEAR(solid.radius_ratio, 1, 1e-15);
  EXPECT_NEAR(solid.least_angle, std::acos(1.0 / 3) * 180 / std::acos(-1.0), 1e-12);
  EXPECT_NEAR(solid.largest_angle, solid.least_angle, 1e-12);
  EXPECT_NEAR(solid.circumradius, std::sqrt(3.0), 1e-15);
}

TEST(CellQuality, DoesNotDependOnScaleAndPlaceNorOnTheOrderButInTheLastBits) {
  for (const auto& cell : {regular_triangle, std::vector<Point>{{0, 0, 0}, {4, 1, 0}, {1, 3, 0}}, regular_tetrahedron,
                           std::vector<Point>{{0, 0, 0}, {4, 1, 0}, {1, 3, 0}, {2, 1, 5}}}) {
    const CellQuality first = quality(cell);
    for (const double scale : {0x1p-900, 0x1p-20, 0x1p30, 0x1p900}) {
      std::vector<Point> other = cell;
      for (Point& p : other) p = {p.x * scale, p.y * scale, p.z * scale};
      std::rotate(other.begin(), other.begin() + 1, other.end());
      const CellQuality found = quality(other);
      EXPECT_NEAR(found.radius_ratio, first.radius_ratio, 1e-14);
      EXPECT_NEAR(found.least_angle, first.least_angle, 1e-12);
      EXPECT_NEAR(found.largest_angle, first.largest_angle, 1e-12);
      EXPECT_NEAR(found.circumradius / scale, first.circumradius, 1e-14 * first.circumradius);
    }
  }
}

TEST(CellQuality, OfFlatCellsIsNotThatOfRoundingErrors) {
  const double little = 0x1p-60;
  const CellQuality sliver = quality({{0, 0, 0}, {1, 0, little}, {1, 1, 0}, {0, 1, little}});
  EXPECT_GT(sliver.radius_ratio, 0);
  EXPECT_LT(sliver.radius_ratio, 1e-15);
  EXPECT_NEAR(sliver.largest_angle, 180, 1e-12);
  EXPECT_GT(sliver.least_angle, 0);
  EXPECT_LT(sliver.least_angle, 1e-12);
  const CellQuality needle = quality({{0, 0, 0}, {1, 0, 0}, {0.5, little, 0}});
  EXPECT_NEAR(needle.circumradius / (0.125 / little), 1, 1e-12);
  EXPECT_NEAR(needle.largest_angle, 180, 1e-12);
}

TEST(CellQuality, OfTheLargestNumbersIsFiniteButForTheRadius) {
  const double most = std::numeric_limits<double>::max();
  const CellQuality found = quality({{-most, -most, 0}, {most, -most, 0}, {0, most, 0}});
  EXPECT_TRUE(std::isfinite(found.radius_ratio) && found.radius_ratio > 0.7);
  EXPECT_TRUE(found.least_angle > 50 && found.largest_angle < 70);
  const CellQuality flat = quality({{-most, 0, 0}, {most, 0, 0}, {0, 1, 0}});
  EXPECT_TRUE(std::isinf(flat.circumradius));
  EXPECT_EQ(flat.radius_ratio, 0);
}

}  // namespace
}  // namespace tessera
