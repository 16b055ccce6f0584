#include "src/result/measure/cell_parts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "src/result/measure/exact_volume.h"
#include "src/result/measure/level_sum.h"
#include "src/result/measure/twofold.h"

namespace tessera::test {
namespace {

using query::Long;
using query::Wide;
using voronoi::CellParts;
using voronoi::long_of;
using Corners = std::array<Point, 4>;

// Of the same value as the two summands of a Twofold.
Wide wide(const Twofold& number) {
  const long double high = rounded(number);
  return Wide(high) + Wide(rounded(number - Twofold(high)));
}

TEST(Twofold, HasTwiceTheDigits) {
  std::mt19937_64 rng(1);
  const auto random = [&] {
    const auto part = [&] {
      return std::ldexp(static_cast<long double>(rng()) - 0x1p63L, static_cast<int>(rng() % 40));
    };
    return Twofold(part()) + Twofold(std::ldexp(part(), -100));
  };
  for (int i = 0; i < 20000; ++i) {
    const Twofold a = random(), b = random();
    const Wide wa = wide(a), wb = wide(b);
    const auto expect_near = [](const Twofold& got, const Wide& right, const Wide& size) {
      EXPECT_LE(abs(Wide(wide(got) - right)), Wide(Twofold::epsilon()) * size);
    };
    expect_near(a + b, wa + wb, abs(wa) + abs(wb));
    expect_near(a - b, wa - wb, abs(wa) + abs(wb));
    expect_near(a * b, wa * wb, abs(wa * wb));
    expect_near(a / b, wa / wb, abs(wa / wb));
    expect_near(sqrt(a * a), abs(wa), abs(wa));
    if (HasFailure()) return;
  }
  EXPECT_EQ(rounded(sqrt(Twofold(0))), 0);
  EXPECT_LT(Twofold(1), Twofold(1) + Twofold(0x1p-100L));
}

TEST(LevelSum, DoesNotDependOnTheOrder) {
  std::mt19937_64 rng(2);
  for (int turn = 0; turn < 300; ++turn) {
    std::vector<long double> terms;
    const int spread = static_cast<int>(rng() % 300) + 1;
    for (std::size_t i = 0; i < 40; ++i) {
      const auto number = static_cast<long double>(rng()) - 0x1p63L;
      terms.push_back(std::ldexp(number, static_cast<int>(rng() % static_cast<unsigned>(spread)) - 600));
      if (rng() % 3 == 0) terms.push_back(-terms[rng() % terms.size()]);
    }
    terms.push_back(0);
    long double first = 0, lowest = 0, most = 0;
    Wide exact = 0;
    for (const long double term : terms) {
      exact += Wide(term);
      most = std::max(most, std::abs(term));
    }
    for (int order = 0; order < 6; ++order) {
      LevelSum<3> sum;
      for (const long double term : terms) sum.add(term);
      if (order == 0) first = sum.value(), lowest = sum.lowest();
      ASSERT_EQ(sum.value(), first);
      ASSERT_EQ(sum.lowest(), lowest);
      std::shuffle(terms.begin(), terms.end(), rng);
    }
    EXPECT_LE(lowest, most * 0x1p-64L);
    EXPECT_LE(abs(Wide(Wide(first) - exact)),
              Wide(lowest) * terms.size() + Wide(std::numeric_limits<Long>::epsilon()) * abs(exact));
  }
}

TEST(LevelSum, OfNumbersThatAreNoneIsNone) {
  for (const long double none : {std::numeric_limits<long double>::infinity(), std::nanl("")}) {
    LevelSum<2> sum;
    sum.add(1);
    sum.add(none);
    sum.add(1e300L);
    EXPECT_TRUE(std::isnan(sum.value()));
  }
  EXPECT_EQ(LevelSum<2>().value(), 0);
}

// Positively oriented. Nothing for cells without a volume.
bool orient(Corners& corners) {
  const auto volume = volume_times_factorial(corners).value;
  if (volume < 0) std::swap(corners[2], corners[3]);
  return volume != 0;
}

// Regular, flat, long and needle-like cells, near the origin and far from it.
std::vector<Corners> kinds_of_cells() {
  std::mt19937_64 rng(3);
  std::normal_distribution<double> normal;
  std::vector<Corners> cells;
  for (int i = 0; i < 4000; ++i) {
    const double far = i % 3 == 0 ? 1e5 : 0, size = std::ldexp(1, static_cast<int>(rng() % 60) - 30);
    const double thin = std::ldexp(1, -static_cast<int>(rng() % 45));
    Corners cell;
    for (std::size_t k = 0; k < 4; ++k) {
      cell[k] = {normal(rng), normal(rng), normal(rng)};
      if (i % 5 == 1) cell[k].z *= thin;                                          // flat
      if (i % 5 == 2) cell[k] = {cell[k].x, cell[k].y * thin, cell[k].z * thin};  // a needle
      if (i % 5 == 3 && k > 0)                                                    // one short edge
        cell[k] = k == 1
                      ? Point{cell[0].x + thin * cell[1].x, cell[0].y + thin * cell[1].y, cell[0].z + thin * cell[1].z}
                      : cell[k];
      if (i % 5 == 4) {  // a sliver: on a circle, nearly
        const double angle = 1.5 * static_cast<double>(k) + 0.1 * normal(rng);
        cell[k] = {std::cos(angle), std::sin(angle), thin * normal(rng)};
      }
    }
    for (Point& p : cell) p = {far + size * p.x, far + size * p.y, far + size * p.z};
    if (orient(cell)) cells.push_back(cell);
  }
  return cells;
}

// The greatest error of volumes, divided by what is told of it.
template <class Number>
Long worst_error(const Corners& cell, Long epsilon, Long flatness_max) {
  const CellParts<Number> parts(cell);
  if (!(parts.flatness() > 0 && parts.flatness() <= flatness_max)) return 0;
  const CellParts<Wide> right(cell);
  Long worst = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    const auto part = parts.of(k);
    Wide value = 0;
    if constexpr (std::is_same_v<Number, Twofold>)
      value = wide(part.volume);
    else
      value = part.volume;
    worst = std::max(worst, long_of(Wide(abs(Wide(value - right.of(k).volume)))) / (epsilon * part.doubt));
  }
  return worst;
}

TEST(VoronoiCellParts, ErrorsAreWithinTheirBounds) {
  Long quick = 0, fine = 0;
  int quick_cells = 0;
  for (const Corners& cell : kinds_of_cells()) {
    const Long error = worst_error<Long>(cell, std::numeric_limits<Long>::epsilon(), 0x1p50L);
    quick = std::max(quick, error);
    quick_cells += error > 0 ? 1 : 0;
    fine = std::max(fine, worst_error<Twofold>(cell, Twofold::epsilon(), 0x1p100L));
  }
  EXPECT_GT(quick_cells, 3000);
  EXPECT_GT(quick, 0);
  EXPECT_LT(quick, 0.5);
  EXPECT_LT(fine, 0.5);
}

TEST(VoronoiCellParts, AddUpToTheCell) {
  for (const Corners& cell : kinds_of_cells()) {
    const CellParts<Wide> parts(cell);
    VoronoiPart<Wide> sum;
    for (std::size_t k = 0; k < 4; ++k) sum.add(parts.of(k));
    const double volume = rounded_quotient(volume_times_factorial(cell), 6);
    ASSERT_NEAR(static_cast<double>(long_of(sum.volume)) / volume, 1, 1e-12);
  }
}

TEST(VoronoiCellParts, OfACornerOfACubeAreKnown) {
  // A corner and its three neighbours: the corner has an eighth of the cube.
  const CellParts<Long> parts(Corners{Point{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {0, 0, 2}});
  const auto part = parts.of(0);
  EXPECT_NEAR(static_cast<double>(part.volume), 1, 1e-18);
  EXPECT_NEAR(static_cast<double>(part.surface), 3, 1e-17);
  for (const Long at : {part.moment.x, part.moment.y, part.moment.z}) EXPECT_NEAR(static_cast<double>(at), 0.5, 1e-17);
  EXPECT_GE(parts.flatness(), 1);
}

}  // namespace
}  // namespace tessera::test
