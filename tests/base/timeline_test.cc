#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>

#include "src/base/progress.h"

namespace tessera {
namespace {

PhaseSpan span(std::uint32_t thread, double begin_s, double end_s) {
  return {Phase::splaying, TileId{7}, thread, begin_s, end_s};
}

TEST(Timeline, KeepsEverySpanOfAShortRun) {
  Timeline timeline;
  for (int i = 0; i < 1000; ++i) timeline.add(span(0, i, i + 0.5));
  EXPECT_EQ(timeline.spans().size(), 1000u);
}

TEST(Timeline, OfAMillionSpansKeepsFewAndLosesNone) {
  Timeline timeline;
  constexpr std::uint32_t n = 1'000'000;
  for (std::uint32_t i = 0; i < n; ++i) {
    timeline.add(span(i % 2, i * 1e-3, i * 1e-3 + 5e-4));
    ASSERT_LE(timeline.spans().size(), 50'000u);
  }
  std::uint64_t times = 0;
  double end_s = 0;
  for (const PhaseSpan& s : timeline.spans()) {
    times += s.times;
    EXPECT_LE(s.begin_s, s.end_s);
    end_s = std::max(end_s, s.end_s);
  }
  EXPECT_EQ(times, n);
  EXPECT_DOUBLE_EQ(end_s, (n - 1) * 1e-3 + 5e-4);
}

TEST(Timeline, LongSpansStayAsTheyAreBesideManyShortOnes) {
  Timeline timeline;
  timeline.add({Phase::triangulating, TileId{3}, 0, 0, 100});
  for (int i = 0; i < 200'000; ++i) timeline.add(span(0, 100 + i * 1e-3, 100 + i * 1e-3 + 5e-4));
  int found = 0;
  for (const PhaseSpan& s : timeline.spans())
    found += s.phase == Phase::triangulating && s.begin_s == 0 && s.end_s == 100;
  EXPECT_EQ(found, 1);
}

}  // namespace
}  // namespace tessera
