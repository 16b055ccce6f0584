#include "src/job/estimate.h"

#include <gtest/gtest.h>

#include "src/base/option.h"

namespace tessera {
namespace {

constexpr std::uint64_t gib = std::uint64_t{1} << 30;

TEST(Estimate, PointsOfTextFilesAreGuessedFromTheirSize) {
  FileInfo told, text;
  told.points = 1000;
  text.content_bytes = 28'000;
  EXPECT_EQ(expected_points({told, text}), 2000u);
}

TEST(Estimate, GrowsWithThePointsAndStaysInTheBudget) {
  const Machine machine{.memory_bytes = gib, .threads = 2};
  const auto small = estimate(3, KernelKind::flat, TileKind::cells, 1'000'000, 200'000, true, 0, machine);
  const auto large = estimate(3, KernelKind::flat, TileKind::cells, 100'000'000, 200'000, true, 0, machine);
  EXPECT_LE(large.memory_bytes, gib);
  EXPECT_NEAR(static_cast<double>(large.result_bytes) / static_cast<double>(small.result_bytes), 100, 1);
  EXPECT_GT(estimate(3, KernelKind::flat, TileKind::cells, 1'000'000, 200'000, true, 0, machine).result_bytes,
            estimate(3, KernelKind::flat, TileKind::cells, 1'000'000, 200'000, false, 0, machine).result_bytes);
}

}  // namespace
}  // namespace tessera
