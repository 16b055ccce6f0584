// Sums have the same bits in any order, and are right to far more than a double.
#include "src/result/measure/order_free_sum.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace tessera {
namespace {

ScaledDouble sum_of(const std::vector<double>& terms) {
  OrderFreeSum sum;
  for (const double term : terms) sum.add(ScaledDouble::of(term));
  return sum.value();
}

TEST(OrderFreeSum, DoesNotDependOnTheOrderNorOnTheParts) {
  std::mt19937_64 random(1);
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<double> terms(1 + random() % 300);
    const int spread = trial % 2 == 0 ? 20 : 600;
    for (double& term : terms)
      term = std::ldexp(std::uniform_real_distribution(-1.0, 1.0)(random),
                        static_cast<int>(random() % static_cast<unsigned>(spread)) - spread / 2);
    const ScaledDouble first = sum_of(terms);
    for (int i = 0; i < 5; ++i) {
      std::shuffle(terms.begin(), terms.end(), random);
      OrderFreeSum whole, part;
      for (std::size_t k = 0; k < terms.size(); ++k) {
        part.add(ScaledDouble::of(terms[k]));
        if (random() % 7 == 0) {
          whole.add(part);
          part = {};
        }
      }
      part.add(whole);
      EXPECT_EQ(part.value().fraction, first.fraction);
      EXPECT_EQ(part.value().exponent, first.exponent);
    }
  }
}

TEST(OrderFreeSum, IsRoundedOnce) {
  std::vector<double> terms;
  long double expected = 0;
  std::mt19937_64 random(2);
  for (int i = 0; i < 1000; ++i) {
    terms.push_back(static_cast<double>(static_cast<std::int64_t>(random() >> 12) - (std::int64_t{1} << 51)));
    expected += static_cast<long double>(terms.back());  // whole numbers, which long doubles hold
  }
  EXPECT_EQ(sum_of(terms).value(), static_cast<double>(expected));
}

TEST(OrderFreeSum, KeepsWhatTermsThatCancelLeave) {
  EXPECT_EQ(sum_of({1e20, 1, -1e20}).value(), 1);
  EXPECT_EQ(sum_of({-1, 0x1p-60}).value(), -1);
  EXPECT_EQ(sum_of({1, -1}).value(), 0);
  EXPECT_EQ(sum_of({}).value(), 0);
  EXPECT_EQ(sum_of({-3, -4}).value(), -7);
}

TEST(OrderFreeSum, TakesNumbersBeyondDoubles) {
  OrderFreeSum sum;
  for (int i = 0; i < 3; ++i) sum.add(ScaledDouble::of(1, -5000));
  EXPECT_EQ(sum.value().fraction, 0.75);
  EXPECT_EQ(sum.value().exponent, -4998);
  sum.spoil();
  sum.add(ScaledDouble::of(1));
  OrderFreeSum other;
  other.add(sum);
  EXPECT_TRUE(other.spoiled());
}

}  // namespace
}  // namespace tessera
