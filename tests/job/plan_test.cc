#include "src/job/plan.h"

#include <gtest/gtest.h>

namespace tessera {
namespace {

constexpr std::uint64_t gib = std::uint64_t{1} << 30;

TEST(Plan, TilesOfAllThreadsFitInMemoryTogether) {
  for (const std::uint64_t memory : {gib / 2, gib, 4 * gib, 64 * gib}) {
    for (const std::uint32_t threads : {1u, 2u, 8u, 16u}) {
      const auto limit = choose_tile_limit(3, 1'000'000'000, {.memory_bytes = memory, .threads = threads});
      ASSERT_TRUE(limit);
      EXPECT_LE(limit.value() * threads * 700, memory / 2);
      EXPECT_GE(limit.value(), 10'000u);
      EXPECT_LE(limit.value(), 1'000'000u);
    }
  }
}

TEST(Plan, EveryThreadGetsSeveralTilesOfACloudThatIsLargeEnough) {
  const auto limit = choose_tile_limit(3, 4'000'000, {.memory_bytes = 64 * gib, .threads = 4}).value();
  EXPECT_GE(4'000'000 / limit, 2u * 4);
  EXPECT_GE(limit, 200'000u);
}

TEST(Plan, ASmallCloudIsNotCutToKeepThreadsBusy) {
  EXPECT_EQ(choose_tile_limit(3, 50'000, {.memory_bytes = 64 * gib, .threads = 64}).value(), 200'000u);
}

TEST(Plan, TooLittleMemoryIsRefusedWithASentenceThatSaysHowMuch) {
  const auto limit = choose_tile_limit(3, 1'000'000, {.memory_bytes = 1 << 20, .threads = 2});
  ASSERT_FALSE(limit);
  EXPECT_EQ(limit.error().code, Errc::memory);
  EXPECT_NE(limit.error().where.find("--memory is too small for 2 threads"), std::string::npos);
  EXPECT_FALSE(check_tile_fits(3, 10'000'000, gib));
  EXPECT_TRUE(check_tile_fits(3, 1'000'000, gib));
}

TEST(Plan, ACloudOfFewPointsNeedsLittleMemory) {
  EXPECT_TRUE(choose_tile_limit(3, 50, {.memory_bytes = 1 << 20, .threads = 2}));
}

TEST(Plan, PointsOfTextFilesAreGuessedFromTheirSize) {
  FileInfo told, text;
  told.points = 1000;
  text.bytes = 28'000;
  EXPECT_EQ(expected_points({told, text}), 2000u);
}

TEST(Plan, EstimatesGrowWithThePointsAndStayInTheBudget) {
  const Machine machine{.memory_bytes = gib, .threads = 2};
  const auto small = estimate(3, 1'000'000, 200'000, true, 0, machine);
  const auto large = estimate(3, 100'000'000, 200'000, true, 0, machine);
  EXPECT_LE(large.memory_bytes, gib);
  EXPECT_NEAR(static_cast<double>(large.result_bytes) / static_cast<double>(small.result_bytes), 100, 1);
  EXPECT_GT(estimate(3, 1'000'000, 200'000, true, 0, machine).result_bytes,
            estimate(3, 1'000'000, 200'000, false, 0, machine).result_bytes);
}

}  // namespace
}  // namespace tessera
