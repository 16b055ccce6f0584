#include "src/base/tile_map.h"

#include <gtest/gtest.h>

#include "src/base/progress.h"

namespace tessera {
namespace {

constexpr TileId tile(std::uint32_t number) { return TileId{number}; }

TEST(TileMap, KnowsNothingBeforeItsRunBegins) {
  TileMap map;
  map.note_reached(tile(0), TileStatus::triangulated);
  EXPECT_EQ(map.stages(), "");
}

TEST(TileMap, FollowsEveryTileThroughItsStages) {
  TileMap map;
  map.begin({}, {5, 0, 7, 1});
  EXPECT_EQ(map.stages(), "weww");
  map.note_reached(tile(0), TileStatus::triangulated);
  map.note_reached(tile(2), TileStatus::triangulated);
  map.note_reached(tile(2), TileStatus::splayed);
  EXPECT_EQ(map.stages(), "tesw");
  map.note_reached(tile(2), TileStatus::stored);
  map.note_reached(tile(2), TileStatus::splayed);  // told late
  EXPECT_EQ(map.stages(), "tedw");
  EXPECT_EQ(map.begun_again(), 0u);
}

TEST(TileMap, CountsTilesThatWereLostAndBegunAgain) {
  TileMap map;
  map.begin({}, {1, 1});
  for (const TileStatus stage : {TileStatus::triangulated, TileStatus::splayed, TileStatus::triangulated})
    map.note_reached(tile(1), stage);
  EXPECT_EQ(map.stages(), "wt");
  EXPECT_EQ(map.begun_again(), 1u);
  map.begin({}, {1, 1});
  EXPECT_EQ(map.stages(), "ww");
  EXPECT_EQ(map.begun_again(), 0u);
}

TEST(TileMap, IsToldByTheSpansOfAJob) {
  Progress progress;
  progress.map.begin({}, {1, 1, 1});
  progress.add_span({Phase::triangulating, tile(0), 0, 0, 1});
  progress.add_span({Phase::splaying, tile(0), 0, 1, 2});
  progress.add_span({Phase::triangulating, tile(1), 1, 0, 1});
  EXPECT_EQ(progress.map.stages(), "stw");
}

TEST(TileMap, TellsHowManyThreadsWorked) {
  Progress progress;
  EXPECT_EQ(progress.busy(2).threads, (std::vector<double>{0, 0}));
  progress.add_span({Phase::triangulating, tile(0), 0, 0, 2});
  EXPECT_EQ(progress.busy(2).threads, (std::vector<double>{1, 1}));
  progress.add_span({Phase::triangulating, tile(1), 1, 1.5, 4});
  const auto busy = progress.busy(4);
  EXPECT_EQ(busy.until_s, 4);
  ASSERT_EQ(busy.threads.size(), 4u);
  const double told[] = {1, 1.5, 1, 1};
  for (std::size_t part = 0; part < 4; ++part) EXPECT_NEAR(busy.threads[part], told[part], 1e-9) << part;
}

}  // namespace
}  // namespace tessera
