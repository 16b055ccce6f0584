// The independent predicates, apart from any triangulation.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "src/geometry/predicates/independent/predicates.h"

namespace tessera::testing {
namespace {

// Distinct points of a small lattice: nearly all ties.
template <std::size_t n>
std::array<Point, n> draw(std::mt19937_64& rng, int side, int dimension) {
  std::array<Point, n> points;
  for (std::size_t i = 0; i < n; ++i) {
    do {
      for (int k = 0; k < dimension; ++k) points[i][k] = static_cast<double>(rng() % static_cast<std::uint64_t>(side));
    } while (std::find(points.begin(), points.begin() + i, points[i]) != points.begin() + i);
  }
  return points;
}

int in_sphere(const std::array<Point, 5>& p) {
  return independent::in_sphere_perturbed_3(p[0], p[1], p[2], p[3], p[4]);
}
int in_circle(const std::array<Point, 4>& p) { return independent::in_circle_perturbed_2(p[0], p[1], p[2], p[3]); }
int orient(const std::array<Point, 5>& p) { return independent::orientation_3(p[0], p[1], p[2], p[3]); }
int orient(const std::array<Point, 4>& p) { return independent::orientation_2(p[0], p[1], p[2]); }

// Makes the vertices (all points but the last) positively oriented.
template <std::size_t n>
void make_positive(std::array<Point, n>& p) {
  if (orient(p) < 0) std::swap(p[0], p[1]);
}

TEST(InSphere, IsNeverATieAndDoesNotDependOnTheOrderOfTheVertices) {
  std::mt19937_64 rng(1);
  for (int round = 0; round < 20000; ++round) {
    auto p = draw<5>(rng, 3, 3);
    if (orient(p) == 0) continue;
    make_positive(p);
    const int side = in_sphere(p);
    ASSERT_NE(side, 0);
    std::shuffle(p.begin(), p.begin() + 4, rng);
    make_positive(p);
    ASSERT_EQ(in_sphere(p), side);
  }
}

// The sign of the determinant of five lifted and perturbed points: the query exchanged with a vertex flips it, and so
// does each exchange that makes the vertices positively oriented again.
TEST(InSphere, IsAntisymmetricInTheQueryAndAVertex) {
  std::mt19937_64 rng(2);
  for (int round = 0; round < 20000; ++round) {
    auto p = draw<5>(rng, 3, 3);
    if (orient(p) == 0) continue;
    make_positive(p);
    const int side = in_sphere(p);
    std::swap(p[rng() % 4], p[4]);
    const int orientation = orient(p);
    if (orientation == 0) continue;
    make_positive(p);
    ASSERT_EQ(in_sphere(p), -side * orientation);
  }
}

TEST(InCircle, IsNeverATieAndDoesNotDependOnTheOrderOfTheVertices) {
  std::mt19937_64 rng(3);
  for (int round = 0; round < 20000; ++round) {
    auto p = draw<4>(rng, 4, 2);
    if (orient(p) == 0) continue;
    make_positive(p);
    const int side = in_circle(p);
    ASSERT_NE(side, 0);
    std::shuffle(p.begin(), p.begin() + 3, rng);
    make_positive(p);
    ASSERT_EQ(in_circle(p), side);
  }
}

TEST(InCircle, IsAntisymmetricInTheQueryAndAVertex) {
  std::mt19937_64 rng(4);
  for (int round = 0; round < 20000; ++round) {
    auto p = draw<4>(rng, 4, 2);
    if (orient(p) == 0) continue;
    make_positive(p);
    const int side = in_circle(p);
    std::swap(p[rng() % 3], p[3]);
    const int orientation = orient(p);
    if (orientation == 0) continue;
    make_positive(p);
    ASSERT_EQ(in_circle(p), -side * orientation);
  }
}

// Away from ties the answer is known: the unit ball, moved and scaled by powers of two.
TEST(InSphere, AgreesWithTheDistanceToTheCentreAwayFromTies) {
  const std::array<Point, 4> vertices{Point{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, 0, 1}};
  for (const double scale : {0x1p-200, 0x1p-30, 1.0, 0x1p60}) {
    std::array<Point, 4> v = vertices;
    for (Point& p : v) p = {p.x * scale, p.y * scale, p.z * scale};
    if (independent::orientation_3(v[0], v[1], v[2], v[3]) < 0) std::swap(v[0], v[1]);
    const auto at = [&](double x, double y, double z) {
      return independent::in_sphere_perturbed_3(v[0], v[1], v[2], v[3], {x * scale, y * scale, z * scale});
    };
    EXPECT_GT(at(0, 0, 0), 0);
    EXPECT_GT(at(0, 0, -std::nextafter(1.0, 0.0)), 0);
    EXPECT_LT(at(0, 0, -std::nextafter(1.0, 2.0)), 0);
    EXPECT_LT(at(3, 3, 3), 0);
    EXPECT_NE(at(0, -1, 0), 0);
  }
}

// Of two points the greater is lifted: (1,1) out of the circle of the other three corners of a square.
TEST(InCircle, TheGreatestPointIsOutsideTheCircleOfTheOthers) {
  EXPECT_LT(independent::in_circle_perturbed_2({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}), 0);
  EXPECT_LT(independent::in_sphere_perturbed_3({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}), 0);
}

TEST(Collinear, IsExact) {
  EXPECT_TRUE(independent::collinear_3({0, 0, 0}, {3, -5, 7}, {9, -15, 21}));
  EXPECT_FALSE(independent::collinear_3({0, 0, 0}, {3, -5, 7}, {9, -15, std::nextafter(21.0, 22.0)}));
  EXPECT_FALSE(independent::collinear_3({0.1, 0.3, 0.7}, {0.2, 0.6, 1.4}, {0.30000000000000004, 0.9, 2.1}));
}

TEST(Orientation, IsExactWhereRoundingLies) {
  const double u = 0x1p-53;
  EXPECT_EQ(independent::orientation_2({0.5, 0.5, 0}, {12, 12, 0}, {24, 24, 0}), 0);
  EXPECT_EQ(independent::orientation_2({0.5 + u, 0.5, 0}, {12, 12, 0}, {24, 24, 0}),
            -independent::orientation_2({0.5, 0.5 + u, 0}, {12, 12, 0}, {24, 24, 0}));
  EXPECT_NE(independent::orientation_2({0.5 + 2 * u, 0.5, 0}, {12, 12, 0}, {24, 24, 0}), 0);
  EXPECT_GT(independent::orientation_3({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 5e-324}), 0);
  EXPECT_EQ(independent::orientation_3({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1e300, -1e300, 0}), 0);
}

}  // namespace
}  // namespace tessera::testing
