// Circumradii against rational numbers.
#include "src/geometry/predicates/exact/circumradius.h"

#include <gtest/gtest.h>

#include <array>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace tessera {
namespace {

using Rational = boost::multiprecision::cpp_rational;
using Row = std::array<Rational, 3>;

Rational dot(const Row& a, const Row& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Row side(const Point& a, const Point& b, bool flat) {
  return {Rational(b.x) - Rational(a.x), Rational(b.y) - Rational(a.y),
          flat ? Rational(0) : Rational(b.z) - Rational(a.z)};
}

// The centre relative to the first corner, as a sum of the sides, by Cramer's rule. The Gram matrix G has the products
// of the sides; G x = diagonal / 2. Returns false for flat simplices.
bool centre_of(const std::vector<Point>& corners, bool flat, Row& centre) {
  std::vector<Row> sides;
  for (std::size_t i = 1; i < corners.size(); ++i) sides.push_back(side(corners[0], corners[i], flat));
  const std::size_t n = sides.size();
  std::vector<std::vector<Rational>> m(n, std::vector<Rational>(n + 1));
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) m[i][j] = dot(sides[i], sides[j]);
    m[i][n] = m[i][i] / 2;
  }
  for (std::size_t i = 0; i < n; ++i) {  // a Gram matrix of independent sides has no pivot 0
    if (m[i][i] == 0) return false;
    for (std::size_t r = 0; r < n; ++r) {
      if (r == i) continue;
      const Rational factor = m[r][i] / m[i][i];
      for (std::size_t c = 0; c <= n; ++c) m[r][c] -= factor * m[i][c];
    }
  }
  centre = {0, 0, 0};
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t axis = 0; axis < 3; ++axis) centre[axis] += m[i][n] / m[i][i] * sides[i][axis];
  return true;
}

void check(const std::vector<Point>& corners, const Point& other, bool flat) {
  Row centre;
  const double infinite = std::numeric_limits<double>::infinity(), largest = std::numeric_limits<double>::max();
  const double up = exact::circumradius_up(corners, flat);
  if (!centre_of(corners, flat, centre)) {
    EXPECT_EQ(up, infinite);
    EXPECT_EQ(exact::compare_circumradius(corners, flat, largest), 1);
    return;
  }
  const Rational square = dot(centre, centre);
  const auto at_least = [&](double r) { return Rational(r) * Rational(r) >= square; };
  if (up == infinite) {
    EXPECT_FALSE(at_least(largest));
    EXPECT_EQ(exact::compare_circumradius(corners, flat, largest), 1);
    return;
  }
  EXPECT_TRUE(at_least(up));
  if (up > 0) {
    EXPECT_FALSE(at_least(std::nextafter(up, 0)));
  }
  for (const double r : {up, std::nextafter(up, 0), std::nextafter(up, infinite), up / 3, 0.0, largest, 1e-310}) {
    if (r < 0 || std::isinf(r)) continue;
    const Rational given = Rational(r) * Rational(r);
    EXPECT_EQ(exact::compare_circumradius(corners, flat, r), square > given ? 1 : square < given ? -1 : 0) << r;
  }
  if (corners.size() == (flat ? 3 : 4)) return;
  Row to = side(corners[0], other, flat);
  for (std::size_t axis = 0; axis < 3; ++axis) to[axis] -= centre[axis];
  EXPECT_EQ(exact::in_smallest_sphere(corners, other, flat), dot(to, to) < square);
}

class Circumradii : public testing::TestWithParam<double> {};

INSTANTIATE_TEST_SUITE_P(Sizes, Circumradii, testing::Values(1, 1e-3, 1e6, 1e-160, 1e150, 1e-308, 1e307, 1e-320));

TEST_P(Circumradii, AreExact) {
  std::mt19937_64 rng(5);
  const auto real = [&] { return static_cast<double>(rng() >> 11) * 0x1p-53; };
  const auto draw = [&](int kind) {
    Point p;
    for (int axis = 0; axis < 3; ++axis) {
      switch (kind) {
        case 0:
          p[axis] = real();
          break;
        case 1:
          p[axis] = static_cast<double>(rng() % 3);  // equal radii, right angles, flat simplices
          break;
        case 2:
          p[axis] = 0.875 + std::ldexp(static_cast<double>(rng() % 8), -52);  // differences of some ulps
          break;
        default:
          p[axis] = std::ldexp(real(), -static_cast<int>(rng() % 60));  // of very different sizes
      }
      p[axis] *= GetParam();
    }
    return p;
  };
  for (int i = 0; i < 400; ++i) {
    for (const bool flat : {true, false}) {
      for (std::size_t corners = 2; corners <= (flat ? 3 : 4); ++corners) {
        std::vector<Point> simplex;
        for (std::size_t k = 0; k < corners; ++k) simplex.push_back(draw(i % 4));
        if (corners > 2 || side(simplex[0], simplex[1], flat) != Row{0, 0, 0}) check(simplex, draw(i % 4), flat);
      }
    }
  }
}

TEST(Circumradius, OfTheUnitSquareIsTheRootOfOneHalf) {
  const std::vector<Point> corners{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  EXPECT_EQ(exact::compare_circumradius(corners, true, std::sqrt(0.5)), -1);  // which is rounded up
  EXPECT_EQ(exact::circumradius_up(corners, true), std::sqrt(0.5));
  EXPECT_EQ(exact::compare_circumradius(corners, true, std::nextafter(std::sqrt(0.5), 0)), 1);
  const std::vector<Point> pythagorean{{0, 0, 0}, {3, 0, 0}, {0, 4, 0}};
  EXPECT_EQ(exact::compare_circumradius(pythagorean, true, 2.5), 0);
  EXPECT_EQ(exact::circumradius_up(pythagorean, true), 2.5);
}

TEST(Circumradius, OfEqualPointsIsZeroForAnEdge) {
  const std::vector<Point> corners{{1, 2, 3}, {1, 2, 3}};
  EXPECT_EQ(exact::compare_circumradius(corners, false, 0), 0);
  EXPECT_EQ(exact::circumradius_up(corners, false), 0);
}

}  // namespace
}  // namespace tessera
