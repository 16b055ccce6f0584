#include "src/exchange/table.h"

#include <gtest/gtest.h>

namespace tessera {
namespace {

TEST(Table, SaysWhereATileLivesAndInWhichLife) {
  const Table table{3, 0, {NodeId{1}, NodeId{0}}, {0, 2}};
  EXPECT_EQ(table.node_of(TileId{0}), NodeId{1});
  EXPECT_EQ(table.peer_of(TileId{1}), (Peer{TileId{1}, 2}));
  EXPECT_TRUE(table.alive({TileId{1}, 2}));
  EXPECT_FALSE(table.alive({TileId{1}, 1}));
  EXPECT_FALSE(table.alive({TileId{1}, 3}));
}

TEST(Table, OfAYoungerIncarnationItDoesNotSayThatItIsDead) {
  const Table table{3, 0, {NodeId{1}, NodeId{0}}, {0, 2}};
  EXPECT_TRUE(table.dead({TileId{1}, 1}));
  EXPECT_FALSE(table.dead({TileId{1}, 2}));
  EXPECT_FALSE(table.dead({TileId{1}, 3}));
}

TEST(Table, EmptyPutsAllTilesOnTheFirstNode) {
  const Table table;
  EXPECT_EQ(table.node_of(TileId{7}), NodeId{0});
  EXPECT_TRUE(table.alive({TileId{7}, 0}));
}

}  // namespace
}  // namespace tessera
