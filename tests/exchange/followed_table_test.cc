#include "src/exchange/followed_table.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

namespace tessera {
namespace {

// Three tiles on nodes 0, 1 and 1, of which tile 2 has begun anew as often as the number of the epoch says.
RoutingTable table(std::uint32_t epoch) {
  return {{{}, epoch}, 0, {NodeId{0}, NodeId{1}, NodeId{1}}, {{}, {}, {{}, epoch}}};
}
std::shared_ptr<const RoutingTable> shared(std::uint32_t epoch) {
  return std::make_shared<const RoutingTable>(table(epoch));
}

TEST(FollowedTable, IsTakenWhenAllTilesHaveSaidSo) {
  FollowedTable followed(shared(0));
  EXPECT_TRUE(followed.is_taken());
  followed.add_changes(table(1));
  ASSERT_TRUE(followed.changes());
  EXPECT_EQ(followed.changes()->tiles, std::vector<TileId>{TileId{2}});
  followed.set(shared(1));
  followed.wait_for(2);
  Epoch first, second;
  followed.take(first, {{}, 1});
  EXPECT_FALSE(followed.is_taken());
  EXPECT_EQ(first, (Epoch{{}, 1}));
  followed.take(first, {{}, 1});
  EXPECT_FALSE(followed.is_taken()) << "one tile has said it twice";
  followed.take(second, {{}, 1});
  EXPECT_TRUE(followed.is_taken());
  EXPECT_FALSE(followed.changes()) << "no tile goes by an older table";
}

TEST(FollowedTable, KeepsTheChangesSinceTheOldestTableThatATileGoesBy) {
  FollowedTable followed(shared(0));
  for (const std::uint32_t epoch : {1, 2}) {
    followed.add_changes(table(epoch));
    followed.set(shared(epoch));
    followed.wait_for(1);
  }
  EXPECT_EQ(followed->epoch, (Epoch{{}, 2}));
  ASSERT_TRUE(followed.changes());
  EXPECT_TRUE(followed.changes()->before);
  Epoch tile;
  followed.take(tile, {{}, 1});
  EXPECT_FALSE(followed.is_taken()) << "that was the table before";
  followed.take(tile, {{}, 2});
  EXPECT_TRUE(followed.is_taken());
}

TEST(FollowedTable, WithoutTilesHasNoChanges) {
  FollowedTable followed(shared(0));
  followed.add_changes(table(1));
  followed.wait_for(0);
  EXPECT_FALSE(followed.changes());
  followed.add_changes(table(1));
  followed.forget_changes();
  EXPECT_FALSE(followed.changes());
}

TEST(FollowedTable, OfAnotherJobIsToldByItsSizes) {
  EXPECT_TRUE(is_table_of_job(table(0), 3, 1, 2));
  EXPECT_FALSE(is_table_of_job(table(0), 4, 1, 2));
  EXPECT_FALSE(is_table_of_job(table(0), 3, 0, 2));
  EXPECT_FALSE(is_table_of_job(table(0), 3, 1, 1)) << "node 1 does not exist";
}

TEST(FollowedTable, GivesWeightToTheTilesOfANodeAlone) {
  EXPECT_EQ(weights_on(NodeId{1}, table(0), {5, 6, 7}), (std::vector<std::uint64_t>{0, 6, 7}));
}

}  // namespace
}  // namespace tessera
