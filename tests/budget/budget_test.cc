#include "src/tiling/budget/budget.h"
#include "src/base/option.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

namespace tessera::budget {
namespace {

constexpr std::uint64_t mib = std::uint64_t{1} << 20, gib = std::uint64_t{1} << 30;
// The M figure behind `words`.
std::uint64_t figure_in(const std::string& sentence, const std::string& words) {
  const auto at = sentence.find(words);
  return at == std::string::npos ? 0 : std::stoull(sentence.substr(at + words.size())) * mib;
}

constexpr KernelKind flat = KernelKind::flat;

TEST(TileLimit, TilesOfAllThreadsFitInMemoryTogether) {
  for (const std::uint64_t memory : {gib / 2, gib, 4 * gib, 64 * gib}) {
    for (const std::uint32_t threads : {1u, 2u, 8u, 16u}) {
      const auto limit = tile_limit(3, flat, 100'000'000, threads, memory);
      ASSERT_TRUE(limit);
      EXPECT_LE(limit.value() * threads * needs(3, flat).triangulate,
                for_tiles(memory, threads, 100'000'000 / limit.value()));
      EXPECT_GE(limit.value(), 10'000u);
      EXPECT_LE(limit.value(), 1'000'000u);
    }
  }
}

TEST(TileLimit, EveryThreadGetsSeveralTilesOfACloudThatIsLargeEnough) {
  const auto limit = tile_limit(3, flat, 4'000'000, 4, 64 * gib).value();
  EXPECT_GE(4'000'000 / limit, 2u * 4);
  EXPECT_GE(limit, 200'000u);
}

TEST(TileLimit, ASmallCloudIsNotCutToKeepThreadsBusy) {
  EXPECT_EQ(tile_limit(3, flat, 50'000, 64, 64 * gib).value(), 200'000u);
}

TEST(TileLimit, TooLittleMemoryIsRefusedWithAFigureThatWouldDo) {
  for (const std::uint32_t threads : {1u, 2u, 8u}) {
    for (const std::uint64_t points : {50u, 5000u, 1'000'000u}) {
      const auto limit = tile_limit(3, flat, points, threads, 1 << 20);
      ASSERT_FALSE(limit);
      EXPECT_EQ(limit.error().code, Errc::memory);
      EXPECT_NE(in_plain_words(limit.error().where).find("memory is too small for " + std::to_string(threads)),
                std::string::npos);
      EXPECT_TRUE(tile_limit(3, flat, points, threads, figure_in(limit.error().where, "at least ")));
      EXPECT_FALSE(tile_limit(3, flat, points, threads, figure_in(limit.error().where, "at least ") - mib));
    }
  }
}

TEST(TileFits, ATileTooLargeIsRefusedWithAFigureThatWouldDo) {
  for (const std::uint64_t points : {50u, 200'000u, 10'000'000u}) {
    const auto fits = tile_fits(3, flat, points, 1, 2, 20 * mib);
    ASSERT_FALSE(fits);
    EXPECT_EQ(fits.error().code, Errc::memory);
    EXPECT_TRUE(tile_fits(3, flat, points, 1, 2, figure_in(fits.error().where, "at least ")));
    EXPECT_FALSE(tile_fits(3, flat, points, 1, 2, figure_in(fits.error().where, "at least ") - 2 * mib));
  }
}

TEST(TileFits, ManyTilesAreRefusedWithAFigureThatWouldDo) {
  EXPECT_TRUE(tile_fits(3, flat, 100, 20'000, 2, 200 * mib));
  const auto fits = tile_fits(3, flat, 100, 20'000, 2, 100 * mib);
  ASSERT_FALSE(fits);
  EXPECT_NE(fits.error().where.find("20000 tiles need about 98M"), std::string::npos) << fits.error().where;
  const std::uint64_t least = figure_in(fits.error().where, "at least ");
  EXPECT_TRUE(tile_fits(3, flat, 100, 20'000, 2, least));
  EXPECT_FALSE(tile_fits(3, flat, 100, 20'000, 2, least - mib));
  // So many come of a large cloud by themselves.
  EXPECT_FALSE(tile_limit(3, flat, 10'000'000'000, 2, 200 * mib));
}

TEST(Budget, EveryPartIsLessThanTheMemoryHoweverSmall) {
  for (const std::uint64_t memory : {mib, 16 * mib, 40 * mib, gib, 100 * gib}) {
    for (const std::uint32_t threads : {1u, 64u}) {
      EXPECT_GT(for_tiles(memory, threads, 1000), 0u);
      EXPECT_LT(for_tiles(memory, threads, 0), memory);
      EXPECT_LE(route_buffer_bytes(memory) + refine_bytes(memory), memory);
      EXPECT_LE(reading_threads(memory, threads), threads);
      EXPECT_GE(reading_threads(memory, threads), 1u);
      const Phases all = phases(3, flat, TileKind::cells, 100'000'000, 100'000, threads, memory);
      EXPECT_EQ(all.bytes.size(), 4u);
      for (const auto& [phase, bytes] : all.bytes) EXPECT_LE(bytes, memory) << name_of(phase);
    }
  }
}

TEST(Budget, TilesStayWholeWhenThereIsRoomForThemAndTheThreadsAtWork) {
  const std::vector<std::uint64_t> tiles(10, 100'000);
  EXPECT_TRUE(fits_whole(tiles, 3, flat, TileKind::cells, 2, gib));
  EXPECT_FALSE(fits_whole(tiles, 3, flat, TileKind::cells, 2, 300 * mib));
  EXPECT_EQ(phases(3, flat, TileKind::cells, 1'000'000, 100'000, 2, gib).whole, true);
  EXPECT_EQ(phases(3, flat, TileKind::cells, 1'000'000, 100'000, 2, 300 * mib).whole, false);
}

TEST(Budget, MailOfAllTilesTogetherStaysASmallPart) {
  for (const std::uint64_t tiles : {1u, 64u, 2000u}) {
    EXPECT_LE(mail_bytes_max(gib, tiles) * tiles, gib / 15);
  }
}

}  // namespace
}  // namespace tessera::budget
