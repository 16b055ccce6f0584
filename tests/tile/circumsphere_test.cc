#include "src/tiling/tile/circumsphere.h"

#include <gtest/gtest.h>

#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <random>

namespace tessera {
namespace {

using Rational = boost::multiprecision::cpp_rational;

struct Exact {
  bool flat = false;
  std::array<Rational, 3> center;
  Rational squared_radius;
};

Exact exact_circumsphere(const std::array<Point, 4>& p) {
  std::array<std::array<Rational, 3>, 3> e;
  std::array<Rational, 3> q;
  for (int k = 0; k < 3; ++k) {
    q[k] = 0;
    for (int i = 0; i < 3; ++i) {
      e[k][i] = Rational(p[k + 1][i]) - Rational(p[0][i]);
      q[k] += e[k][i] * e[k][i];
    }
  }
  const auto cross = [&](int a, int b, int i) {
    return Rational(e[a][(i + 1) % 3] * e[b][(i + 2) % 3] - e[a][(i + 2) % 3] * e[b][(i + 1) % 3]);
  };
  Rational det = 0;
  for (int i = 0; i < 3; ++i) det += e[0][i] * cross(1, 2, i);
  Exact out;
  if (det == 0) {
    out.flat = true;
    return out;
  }
  out.squared_radius = 0;
  for (int i = 0; i < 3; ++i) {
    const Rational o = (q[0] * cross(1, 2, i) + q[1] * cross(2, 0, i) + q[2] * cross(0, 1, i)) / (2 * det);
    out.squared_radius += o * o;
    out.center[i] = Rational(p[0][i]) + o;
  }
  return out;
}

// The true sphere is inside the ball: |c - c'| + r <= reach, checked without square roots.
bool encloses(const Ball& ball, const Exact& exact) {
  Rational gap = 0;
  for (int i = 0; i < 3; ++i) {
    const Rational d = exact.center[i] - Rational(ball.center[i]);
    gap += d * d;
  }
  const Rational reach(ball.radius);
  const Rational rest = reach * reach - gap - exact.squared_radius;  // must be >= 2 sqrt(gap r^2)
  return rest >= 0 && rest * rest >= 4 * gap * exact.squared_radius;
}

TEST(Circumsphere, BallContainsTheExactSphereForCoordinatesOfEverySize) {
  std::mt19937_64 rng(7);
  int known = 0;
  for (int round = 0; round < 20000; ++round) {
    const double scale = std::ldexp(1.0, static_cast<int>(rng() % 120) - 60);
    const double offset = round % 2 ? 0 : scale * static_cast<double>(rng() % 10000000);
    const bool quantised = round % 3 == 0, flat = round % 5 == 0;
    std::array<Point, 4> p;
    for (auto& q : p) {
      for (int i = 0; i < 3; ++i) {
        double u = static_cast<double>(rng() >> 11) * 0x1p-53;
        if (quantised) u = std::round(u * 8);
        if (flat && i == 2) u *= 0x1p-40;
        q[i] = u * scale + offset;
      }
    }
    const Ball ball = circumsphere(p[0], p[1], p[2], p[3]);
    if (!ball.known) continue;
    ++known;
    const Exact exact = exact_circumsphere(p);
    ASSERT_FALSE(exact.flat);
    ASSERT_TRUE(encloses(ball, exact)) << "round " << round;
  }
  EXPECT_GT(known, 12000);
}

TEST(Circumsphere, BallIsTightForRoundCells) {
  const Ball ball = circumsphere({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1});
  ASSERT_TRUE(ball.known);
  EXPECT_NEAR(ball.radius, std::sqrt(0.75), 1e-13);
}

TEST(Circumsphere, NothingIsKnownOfFlatOrExtremeCells) {
  EXPECT_FALSE(circumsphere({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}).known);
  EXPECT_FALSE(circumsphere({0, 0, 0}, {1e200, 0, 0}, {0, 1e200, 0}, {0, 0, 1e200}).known);
  EXPECT_FALSE(circumsphere({0, 0, 0}, {5e-324, 0, 0}, {0, 5e-324, 0}, {0, 0, 5e-324}).known);
  EXPECT_FALSE(circumcircle({0, 0, 0}, {1, 1, 0}, {2, 2, 0}).known);
}

TEST(Circumsphere, ASphereThatTouchesTheBoxIsNotSurelyInside) {
  // Unit cube corners: centre (.5 .5 .5), radius sqrt(3)/2; the circle below touches the box exactly.
  const Ball circle = circumcircle({1, 0, 0}, {0, 1, 0}, {-1, 0, 0});
  Box box;
  box.lo.x = -1;
  EXPECT_FALSE(surely_inside(circle, box, 2));
  box.lo.x = -1.0001;
  EXPECT_TRUE(surely_inside(circle, box, 2));
}

}  // namespace
}  // namespace tessera
