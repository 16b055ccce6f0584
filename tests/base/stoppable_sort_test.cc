#include "src/base/stoppable_sort.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <random>
#include <vector>

namespace tessera {
namespace {

std::vector<std::uint32_t> numbers() {
  std::mt19937 random(1);
  std::vector<std::uint32_t> numbers(1 << 18);
  for (auto& number : numbers) number = static_cast<std::uint32_t>(random());
  return numbers;
}

TEST(StoppableSort, SortsAsTheStandardLibraryDoes) {
  auto ours = numbers(), theirs = numbers();
  std::sort(theirs.begin(), theirs.end(), std::greater<>());
  sort_unless_stopped(ours.begin(), ours.end(), {}, std::greater<>());
  EXPECT_EQ(ours, theirs);
}

TEST(StoppableSort, EndsWithAllElementsInSomeOrderWhenItIsStopped) {
  auto ours = numbers(), all = numbers();
  std::stop_source stop;
  std::uint64_t asked = 0;
  const auto less = [&](std::uint32_t a, std::uint32_t b) {
    if (++asked == 1000) stop.request_stop();
    return a < b;
  };
  EXPECT_THROW(sort_unless_stopped(ours.begin(), ours.end(), stop.get_token(), less), Stopped);
  EXPECT_LT(asked, ours.size());
  std::sort(ours.begin(), ours.end());
  std::sort(all.begin(), all.end());
  EXPECT_EQ(ours, all);
}

}  // namespace
}  // namespace tessera
