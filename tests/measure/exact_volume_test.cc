#include "src/result/measure/exact_volume.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace tessera {
namespace {

using Fraction = boost::multiprecision::cpp_rational;

Fraction fraction_of(const ScaledInteger& number) {
  Fraction value(boost::multiprecision::cpp_int(number.value));
  const auto power = boost::multiprecision::cpp_int(1) << static_cast<unsigned>(std::abs(number.exponent));
  return number.exponent < 0 ? Fraction(value / Fraction(power)) : Fraction(value * Fraction(power));
}

// By Leibniz, in fractions.
Fraction determinant(const std::vector<Point>& p) {
  const int d = static_cast<int>(p.size()) - 1;
  const auto e = [&](int i, int axis) {
    return Fraction(p[static_cast<std::size_t>(i) + 1][axis]) - Fraction(p[0][axis]);
  };
  if (d == 2) return e(0, 0) * e(1, 1) - e(0, 1) * e(1, 0);
  return e(0, 0) * e(1, 1) * e(2, 2) + e(0, 1) * e(1, 2) * e(2, 0) + e(0, 2) * e(1, 0) * e(2, 1) -
         e(0, 2) * e(1, 1) * e(2, 0) - e(0, 1) * e(1, 0) * e(2, 2) - e(0, 0) * e(1, 2) * e(2, 1);
}

// No other double is nearer, and of two that are as near it is the even one.
void expect_nearest(const Fraction& exact, double rounded) {
  const double infinity = std::numeric_limits<double>::infinity();
  ASSERT_TRUE(std::isfinite(rounded));
  const Fraction off = abs(exact - Fraction(rounded));
  for (const double other : {std::nextafter(rounded, infinity), std::nextafter(rounded, -infinity)}) {
    if (!std::isfinite(other)) continue;
    const Fraction theirs = abs(exact - Fraction(other));
    EXPECT_LE(off, theirs);
    if (off == theirs) {
      int exponent = 0;
      const double mantissa = std::ldexp(std::frexp(rounded, &exponent), 53);
      EXPECT_EQ(std::fmod(mantissa, 2), 0);
    }
  }
}

std::vector<Point> random_corners(std::mt19937_64& rng, int dimension, int scales) {
  std::uniform_real_distribution<double> in(-1, 1);
  std::uniform_int_distribution<int> scale(-scales, scales);
  std::vector<Point> corners(static_cast<std::size_t>(dimension) + 1);
  for (Point& p : corners)
    for (int axis = 0; axis < dimension; ++axis) p[axis] = std::ldexp(in(rng), scale(rng));
  return corners;
}

class ExactVolume : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Dimensions, ExactVolume, testing::Values(2, 3));

TEST_P(ExactVolume, IsTheDeterminantOfTheCorners) {
  std::mt19937_64 rng(1);
  for (const int scales : {0, 3, 12, 60, 300}) {
    for (int i = 0; i < 500; ++i) {
      const auto corners = random_corners(rng, GetParam(), scales);
      ASSERT_EQ(fraction_of(volume_times_factorial(corners)), determinant(corners)) << "scales " << scales;
    }
  }
}

TEST_P(ExactVolume, DoesNotDependOnTheOrderOfTheCornersButForTheSign) {
  std::mt19937_64 rng(2);
  auto corners = random_corners(rng, GetParam(), 5);
  const Fraction first = abs(fraction_of(volume_times_factorial(corners)));
  for (int i = 0; i < 24; ++i) {
    std::shuffle(corners.begin(), corners.end(), rng);
    EXPECT_EQ(abs(fraction_of(volume_times_factorial(corners))), first);
  }
}

TEST(ExactVolumeOf, FlatSimplicesIsZero) {
  const std::vector<Point> flat{{0.1, 0.1, 0}, {0.2, 0.2, 0}, {0.4, 0.4, 0}};
  EXPECT_EQ(volume_times_factorial(flat).value, 0);
  const std::vector<Point> zeros(4);
  EXPECT_EQ(volume_times_factorial(zeros).value, 0);
}

TEST(RoundedQuotient, IsTheNearestDouble) {
  std::mt19937_64 rng(3);
  for (int i = 0; i < 3000; ++i) {
    boost::multiprecision::cpp_int value = rng();
    for (int more = static_cast<int>(rng() % 4); more > 0; --more) value = (value << 64) + rng();
    if (rng() % 2 == 0) value >>= 40 + rng() % 20;
    if (rng() % 2 == 0) value = -value;
    const ScaledInteger number{Integer(value), static_cast<int>(rng() % 1200) - 1350};
    for (const unsigned divisor : {1u, 2u, 6u}) {
      const double rounded = rounded_quotient(number, divisor);
      expect_nearest(fraction_of(number) / divisor, rounded);
    }
  }
}

TEST(RoundedQuotient, KnowsWhereDoublesEnd) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(rounded_quotient({1, 1023}, 1), std::ldexp(1.0, 1023));
  EXPECT_EQ(rounded_quotient({1, 1024}, 1), infinity);
  EXPECT_EQ(rounded_quotient({-1, 3000}, 6), -infinity);
  EXPECT_EQ(rounded_quotient({6, 1023}, 6), std::ldexp(1.0, 1023));
  EXPECT_EQ(rounded_quotient({1, -1074}, 1), std::ldexp(1.0, -1074));
  EXPECT_EQ(rounded_quotient({1, -1075}, 1), 0) << "a tie goes to the even one";
  EXPECT_EQ(rounded_quotient({3, -1075}, 1), std::ldexp(1.0, -1073)) << "a tie goes to the even one";
  EXPECT_EQ(rounded_quotient({3, -1076}, 1), std::ldexp(1.0, -1074));
  EXPECT_EQ(rounded_quotient({1, -3000}, 2), 0);
  EXPECT_EQ(rounded_quotient({0, 0}, 6), 0);
}

TEST(ExactSum, DoesNotDependOnTheOrder) {
  std::mt19937_64 rng(4);
  std::vector<ScaledInteger> numbers;
  Fraction all = 0;
  for (int i = 0; i < 300; ++i) {
    numbers.push_back({static_cast<std::int64_t>(rng()), static_cast<int>(rng() % 400) - 200});
    all += fraction_of(numbers.back());
  }
  for (int turn = 0; turn < 5; ++turn) {
    std::shuffle(numbers.begin(), numbers.end(), rng);
    ExactSum whole, part;
    for (std::size_t i = 0; i < numbers.size(); ++i) (i % 3 == 0 ? part : whole).add(numbers[i]);
    whole.add(part);
    EXPECT_EQ(fraction_of(whole.value()), all);
  }
}

}  // namespace
}  // namespace tessera
