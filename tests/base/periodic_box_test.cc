#include "src/base/periodic_box.h"

#include <gtest/gtest.h>

#include <bit>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <cstdint>
#include <memory>
#include <random>

namespace tessera {
namespace {

using Exact = boost::multiprecision::cpp_rational;

TEST(PeriodicBox, StepIsTheLeastPowerOfTwoOfWhichThePeriodHasAtMostTwoToThe51) {
  for (const double length : {1.0, 0.75, 100.0, 3.5e-7, 1e200, 1e-200, std::ldexp(1, 51), std::nextafter(1.0, 2.0)}) {
    const double step = step_of(length);
    EXPECT_EQ(std::frexp(step, std::make_unique<int>().get()), 0.5);
    EXPECT_LE(length / step, std::ldexp(1, 51));
    EXPECT_GT(length / step, std::ldexp(1, 50));
  }
  EXPECT_TRUE(is_period(100));
  EXPECT_TRUE(is_period(0.5));
  EXPECT_FALSE(is_period(0.1));
  EXPECT_TRUE(is_period(in_steps(0.1)));
  EXPECT_FALSE(is_period(0));
  EXPECT_FALSE(is_period(-1));
  EXPECT_FALSE(is_period(std::nan("")));
  EXPECT_FALSE(is_period(INFINITY));
}

// The place differs from the coordinate by a whole number of periods and the change, exactly; and images do not round.
TEST(PeriodicBox, PlacesAreExact) {
  std::mt19937_64 rng(1);
  const auto any = [&](int spread) {
    const double digits = static_cast<double>(static_cast<std::int64_t>(rng()) >> (rng() % 63));
    return std::ldexp(digits, static_cast<int>(rng() % static_cast<unsigned>(spread)) - 63);
  };
  for (int i = 0; i < 100'000; ++i) {
    const double length = in_steps(std::abs(any(20)) + 1e-9);
    const PeriodicBox box(Period{{length, 0, 0}});
    const double x = rng() % 16 == 0   ? std::round(any(40)) * length
                     : rng() % 16 == 0 ? -std::abs(any(8)) * 1e-30
                                       : any(40);
    if (box.is_far(x, 0)) continue;
    const auto [to, change] = box.moved(x, 0);
    ASSERT_TRUE(0 <= to && to < length && !std::signbit(to)) << x << " " << length;
    ASSERT_TRUE(is_in_period(to, length)) << x << " " << length;
    ASSERT_LE(change, step_of(length) / 2);
    bool found = false;
    for (const int sign : {-1, 1}) {
      const Exact periods = (Exact(x) + sign * Exact(change) - Exact(to)) / Exact(length);
      found |= denominator(periods) == 1;
    }
    ASSERT_TRUE(found) << x << " " << length;
    for (const double shift : {-length, length}) ASSERT_EQ(Exact(to + shift), Exact(to) + Exact(shift));
  }
}

}  // namespace
}  // namespace tessera
