#include "src/surface/energy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "src/surface/cut/cut_graph.h"

namespace tessera::surface {
namespace {

TEST(Energy, TheExponentialIsThatOfTheLibraryToAFewUnits) {
  for (double x = 0; x < 39.9; x += 0.00137) EXPECT_NEAR(exp_of_minus(x) / std::exp(-x), 1, 1e-15) << x;
  EXPECT_EQ(exp_of_minus(0), 1);
  EXPECT_EQ(exp_of_minus(41), 0);
  EXPECT_EQ(exp_of_minus(std::numeric_limits<double>::infinity()), 0);
}

// Bits that no compiler and no machine may change.
TEST(Energy, TheExponentialHasTheseBits) {
  EXPECT_EQ(exp_of_minus(0.5), 0x1.368b2fc6f960ap-1);
  EXPECT_EQ(exp_of_minus(1), 0x1.78b56362cef38p-2);
  EXPECT_EQ(exp_of_minus(12.25), 0x1.411fb0da07713p-18);
}

// Known by hand: a facet 3 scales from its vertex, and others at 2 and 18/7 of a scale of 4.
TEST(Energy, VisibilityIsThatOfFixturesSolvedByHand) {
  EXPECT_EQ(visibility_weight(3, 1, full_vote), std::lround(full_vote * 0.9888910034617577));
  EXPECT_EQ(visibility_weight(2, 4, full_vote), std::lround(full_vote * 0.11750309741540454));
  EXPECT_EQ(visibility_weight(18.0 / 7, 4, full_vote), std::lround(full_vote * 0.18668163487015432));
  EXPECT_EQ(visibility_weight(0, 1, full_vote), 0u);
  EXPECT_EQ(visibility_weight(1e300, 1, full_vote), full_vote);
}

// The facet is seen from the centres of both spheres under the same angle: its plane and the spheres meet at 60 degrees
// for a regular tetrahedron whose centre is a third of its radius above the facet.
TEST(Energy, QualityOfARegularTetrahedronsFacetIsKnown) {
  const std::array<Corner, 3> facet{Corner{{1, 1, 1}, PointId{5}}, Corner{{1, -1, -1}, PointId{2}},
                                    Corner{{-1, 1, -1}, PointId{9}}};
  const Corner apex{{-1, -1, 1}, PointId{3}};
  const Energy energy{.lambda = 32, .alpha = 32};
  EXPECT_EQ(quality_weight(facet, apex, nullptr, energy), std::lround(full_vote * (1 - 1.0 / 3)));
  // Mirrored at the facet the other side is the same.
  const Corner below{{5.0 / 3, 5.0 / 3, -5.0 / 3}, PointId{7}};
  EXPECT_EQ(quality_weight(facet, apex, &below, energy), std::lround(full_vote * (1 - 1.0 / 3)));
}

TEST(Energy, QualityIsTheSameInWhateverOrderATileHasTheCorners) {
  std::array<Corner, 3> facet{Corner{{0.1, 0.7, 3e5}, PointId{5}}, Corner{{1.3, -0.2, 3e5}, PointId{2}},
                              Corner{{-0.4, 0.33, 3e5 + 1}, PointId{9}}};
  const Corner a{{0.1, 0.2, 3e5 + 3}, PointId{4}}, b{{0.1, 0.2, 3e5 - 7}, PointId{1}};
  const auto weight = quality_weight(facet, a, &b, {});
  EXPECT_GT(weight, 0u);
  const auto by_id = [](const Corner& p, const Corner& q) { return p.id < q.id; };
  std::sort(facet.begin(), facet.end(), by_id);
  do {
    EXPECT_EQ(quality_weight(facet, a, &b, {}), weight);
    EXPECT_EQ(quality_weight(facet, b, &a, {}), weight);
  } while (std::next_permutation(facet.begin(), facet.end(), by_id));
}

// Of facets like needles normals are mostly rounding, which tiles must do in one order.
TEST(Energy, QualityIsTheSameInAnyOrderThoughRoundingIsNot) {
  const Energy energy{.lambda = 1e4, .alpha = 1};
  std::mt19937_64 random(1);
  const auto number = [&] { return static_cast<double>(random() >> 11u) * 0x1p-53; };
  for (int round = 0; round < 2000; ++round) {
    const Point from{number(), number(), number()}, to{number(), number(), number()};
    const auto between = [&](double part) {
      return Point{from.x + (to.x - from.x) * part, from.y + (to.y - from.y) * part, from.z + (to.z - from.z) * part};
    };
    std::array<Corner, 3> facet{Corner{from, PointId{1}}, Corner{between(number()), PointId{5}},
                                Corner{to, PointId{3}}};
    const Corner a{{number(), number(), number()}, PointId{4}}, b{{number(), number(), number()}, PointId{2}};
    const auto by_id = [](const Corner& p, const Corner& q) { return p.id < q.id; };
    const auto weight = quality_weight(facet, a, &b, energy);
    std::sort(facet.begin(), facet.end(), by_id);
    do {
      ASSERT_EQ(quality_weight(facet, b, &a, energy), weight);
    } while (std::next_permutation(facet.begin(), facet.end(), by_id));
  }
}

TEST(Energy, AFlatCellsSphereSaysNothing) {
  const std::array<Corner, 3> facet{Corner{{0, 0, 0}, PointId{0}}, Corner{{1, 0, 0}, PointId{1}},
                                    Corner{{0, 1, 0}, PointId{2}}};
  const Energy energy{.lambda = 32, .alpha = 32};
  EXPECT_EQ(quality_weight(facet, {{1, 1, 0}, PointId{3}}, nullptr, energy), full_vote);
}

TEST(Energy, SumsStopAtACapacity) {
  EXPECT_EQ(saturating(3, 4), 7u);
  EXPECT_EQ(saturating(cut::capacity_max, 1), cut::capacity_max);
  EXPECT_EQ(saturating(cut::capacity_max, cut::capacity_max), cut::capacity_max);
}

TEST(Energy, ThePartOfAWayToAPlaneIsTheSameInAnyOrder) {
  const Corner a{{0, 0, 2}, PointId{1}}, b{{1, 0, 2}, PointId{0}}, c{{0, 1, 2.1}, PointId{2}};
  EXPECT_EQ(part_to_plane({0, 0, 0}, {0, 0, 10}, a, b, c), 0.2);
  EXPECT_NEAR(part_to_plane({0, 0, 0}, {3, 0, 4}, a, b, c), 0.5, 1e-15);
  const double part = part_to_plane({0.1, 0.2, 0.3}, {0.7, 0.1, 4}, a, b, c);
  EXPECT_EQ(part_to_plane({0.1, 0.2, 0.3}, {0.7, 0.1, 4}, b, c, a), part);
  EXPECT_EQ(part_to_plane({0.1, 0.2, 0.3}, {0.7, 0.1, 4}, c, b, a), part);
  EXPECT_EQ(part_to_plane({0.1, 0.2, 0.3}, {0.7, 0.1, 4}, b, a, c), part);
  EXPECT_FALSE(std::isfinite(part_to_plane({0, 0, 0}, {1, 0, 0}, a, b, c)));
}

// Votes that are certain are told without the exponential.
TEST(Energy, VisibilityBecomesAWholeVoteWhereItIsNearlyOne) {
  for (double d = 4; d < 5; d += 1e-4)
    EXPECT_EQ(visibility_weight(d, 1, full_vote),
              static_cast<std::uint32_t>(full_vote * (1 - exp_of_minus(d * d / 2)) + 0.5));
}

}  // namespace
}  // namespace tessera::surface
