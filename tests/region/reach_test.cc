// What a cell can be changed from: never less than it is, and not much more.
#include "src/result/region/reach.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <span>

#include "src/geometry/predicates/exact/predicates.h"

namespace tessera {
namespace {

Bounds box_of(const Point& p) { return {p, p}; }

class SphereReaches : public testing::TestWithParam<int> {};

// Of points as boxes, the exact predicate knows. Cells on a lattice far from 0, some of them so flat that no double
// tells where their centre is.
TEST_P(SphereReaches, HaveAllThatIsInTheClosedSphereAndLittleElse) {
  const int dimension = GetParam();
  std::mt19937_64 random(static_cast<std::uint64_t>(dimension));
  int on = 0, inside = 0, unknown = 0, more = 0, cases = 0;
  while (cases < 4000) {
    const bool flat = random() % 4 == 0;
    const auto draw = [&] {
      Point p;
      double sum = 0;
      for (int axis = 0; axis < dimension; ++axis) {
        p[axis] = static_cast<double>(random() % 8) * (flat ? 1e5 : 0x1p-6);
        sum += p[axis];
      }
      if (flat) p[dimension - 1] = 8e5 * dimension - sum;  // in one plane, or off by a bit
      for (int axis = 0; axis < dimension; ++axis) p[axis] += 6.8e6;
      if (flat && random() % 2 == 0) p[0] = std::nextafter(p[0], 9e6);
      return p;
    };
    std::array<Point, 4> cell{};
    for (int i = 0; i <= dimension; ++i) cell[static_cast<std::size_t>(i)] = draw();
    const auto [a, b, c, d] = cell;
    const int side = dimension == 3 ? exact::orientation_3(a, b, c, d) : exact::orientation_2(a, b, c);
    if (side == 0) continue;
    if (side < 0) std::swap(cell[0], cell[1]);
    ++cases;
    const std::span<const Point> vertices = std::span(cell).first(static_cast<std::size_t>(dimension) + 1);
    const SphereReach reach(vertices);
    unknown += dimension == 3 ? !circumsphere(cell[0], cell[1], cell[2], cell[3]).known
                              : !circumcircle(cell[0], cell[1], cell[2]).known;
    for (int i = 0; i < 10; ++i) {
      const Point p = draw();
      const int in = dimension == 3 ? exact::in_sphere_3(cell[0], cell[1], cell[2], cell[3], p)
                                    : exact::in_circle_2(cell[0], cell[1], cell[2], p);
      on += in == 0;
      inside += in > 0;
      const bool met = reach.meets(box_of(p));
      if (in >= 0) {
        ASSERT_TRUE(met);
      }
      more += !flat && met && in < 0;
    }
  }
  EXPECT_GT(on, 100);
  EXPECT_GT(inside, 1000);
  EXPECT_GT(unknown, 5);
  EXPECT_LT(more, 40) << "points outside of the sphere that rounding took in";
}

INSTANTIATE_TEST_SUITE_P(Dimensions, SphereReaches, testing::Values(2, 3));

TEST(SphereReach, MeetsABoxThatHoldsItAndOneThatCutsOff) {
  const std::array<Point, 3> cell{Point{0, 0}, Point{2, 0}, Point{0, 2}};  // around (1, 1), its square is 2
  const SphereReach reach(cell);
  EXPECT_TRUE(reach.meets({{-9, -9, 0}, {9, 9, 0}}));
  EXPECT_TRUE(reach.meets({{2.4, -9, 0}, {9, 9, 0}}));
  EXPECT_FALSE(reach.meets({{2.4, 2.4, 0}, {9, 9, 0}}));
  EXPECT_TRUE(reach.meets({{2, 2, 0}, {9, 9, 0}})) << "it touches";
}

TEST(HullReach, IsWhatIsStrictlyBeyondTheFacet) {
  const std::array<Point, 4> cell{Point{0, 0, 0}, Point{0, 0, 0}, Point{1, 0, 0}, Point{0, 1, 0}};
  const HullReach reach(cell, 0);  // above or below z = 0
  const int above = reach.side({{5, 5, 1}, {6, 6, 2}});
  EXPECT_EQ(std::abs(above), 1);
  EXPECT_EQ(reach.side({{5, 5, -2}, {6, 6, -1}}), -above);
  EXPECT_EQ(reach.side({{5, 5, 0}, {6, 6, 0}}), 0);
  EXPECT_TRUE(reach.meets({{5, 5, -1}, {6, 6, 1}}));
  EXPECT_FALSE(reach.meets({{5, 5, 0}, {6, 6, 0}}));
  EXPECT_NE(reach.meets({{5, 5, 0}, {6, 6, 1}}), reach.meets({{5, 5, -1}, {6, 6, 0}}));
}

}  // namespace
}  // namespace tessera
