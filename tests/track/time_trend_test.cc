#include "src/surface/track/time_trend.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <vector>

namespace tessera {
namespace {

const std::vector<double> times{-1, 0, 2, 3, 7};
const std::vector<double> weights{1, 4, 0.5, 2, 1};
const std::vector<double> values{5, -3, 8, 8, 1};

TEST(TimeTrend, FindsTheLineThatValuesLieOnWhateverTheWeights) {
  std::vector<double> on_line;
  for (const double time : times) on_line.push_back(10 - 3 * time);
  const TimeTrend trend(times, weights);
  EXPECT_NEAR(trend.line(on_line).at_zero, 10, 1e-12);
  EXPECT_NEAR(trend.line(on_line).speed, -3, 1e-12);
  for (const double rest : trend.rest(on_line)) EXPECT_NEAR(rest, 0, 1e-12);
}

TEST(TimeTrend, AWeightOfTwoCountsAsTwoEqualObservations) {
  const std::vector<double> two{1, 2, 1, 1, 1}, ones(6, 1);
  const std::vector<double> times_twice{-1, 0, 0, 2, 3, 7}, values_twice{5, -3, -3, 8, 8, 1};
  const auto once = TimeTrend(times, two).line(values), twice = TimeTrend(times_twice, ones).line(values_twice);
  EXPECT_NEAR(once.at_zero, twice.at_zero, 1e-12);
  EXPECT_NEAR(once.speed, twice.speed, 1e-12);
}

TEST(TimeTrend, IsLevelWhenAllTimesAreEqual) {
  const std::vector<double> same(3, 4), of{1, 1, 2}, heights{10, 20, 30};
  const auto line = TimeTrend(same, of).line(heights);
  EXPECT_EQ(line.speed, 0);
  EXPECT_EQ(line.at_zero, 22.5);
}

TEST(TimeTrend, WhatIsLeftHasNoMeanAndNoTrend) {
  const TimeTrend trend(times, weights);
  const std::vector<double> ones(times.size(), 1), rest = trend.rest(values);
  EXPECT_NEAR(trend.sum(rest, ones), 0, 1e-12);
  EXPECT_NEAR(trend.sum(rest, times), 0, 1e-12);
  EXPECT_EQ(trend.weight(), 8.5);
  EXPECT_EQ(trend.sum(ones, ones), trend.weight());
  const auto [at_zero, speed] = trend.line(values);
  for (std::size_t i = 0; i < times.size(); ++i) EXPECT_NEAR(rest[i], values[i] - at_zero - speed * times[i], 1e-12);
}

}  // namespace
}  // namespace tessera
