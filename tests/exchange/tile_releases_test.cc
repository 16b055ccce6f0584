#include "src/exchange/tile_releases.h"

#include <gtest/gtest.h>

#include <vector>

namespace tessera {
namespace {

TEST(TileReleases, AreAnsweredWhenAllTilesHaveLeft) {
  TileReleases releases;
  releases.give_up(TileId{4});
  releases.give_up(TileId{3});
  releases.ask();
  releases.ask();
  EXPECT_FALSE(releases.answer());
  releases.leave();
  EXPECT_FALSE(releases.all_have_left());
  EXPECT_FALSE(releases.answer());
  releases.leave();
  EXPECT_TRUE(releases.all_have_left());
  EXPECT_EQ(releases.answer().value(), (std::vector<TileId>{TileId{4}, TileId{3}}));
  EXPECT_EQ(releases.answer().value(), std::vector<TileId>{}) << "one answer for each time";
  EXPECT_FALSE(releases.answer());
}

TEST(TileReleases, AreNotOwedToAnotherCoordinatorThoughTilesStillLeave) {
  TileReleases releases;
  releases.give_up(TileId{4});
  releases.ask();
  releases.forget_asked();
  EXPECT_FALSE(releases.all_have_left());
  releases.leave();
  EXPECT_TRUE(releases.all_have_left());
  EXPECT_FALSE(releases.answer());
}

}  // namespace
}  // namespace tessera
