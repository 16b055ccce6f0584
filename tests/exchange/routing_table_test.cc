#include "src/exchange/routing_table.h"

#include <gtest/gtest.h>

namespace tessera {
namespace {

Incarnation life(std::uint32_t number) { return {{}, number}; }

TEST(RoutingTable, SaysWhereATileLivesAndInWhichLife) {
  const RoutingTable table{{{}, 3}, 0, {NodeId{1}, NodeId{0}}, {life(0), life(2)}};
  EXPECT_EQ(table.node_of(TileId{0}), NodeId{1});
  EXPECT_EQ(table.peer_of(TileId{1}), (TileIncarnation{TileId{1}, life(2)}));
  EXPECT_TRUE(table.alive({TileId{1}, life(2)}));
  EXPECT_FALSE(table.alive({TileId{1}, life(1)}));
  EXPECT_FALSE(table.alive({TileId{1}, life(3)}));
}

TEST(RoutingTable, OfAYoungerIncarnationItDoesNotSayThatItIsDead) {
  const RoutingTable table{{{}, 3}, 0, {NodeId{1}, NodeId{0}}, {life(0), life(2)}};
  EXPECT_TRUE(table.dead({TileId{1}, life(1)}));
  EXPECT_FALSE(table.dead({TileId{1}, life(2)}));
  EXPECT_FALSE(table.dead({TileId{1}, life(3)}));
}

TEST(RoutingTable, EmptyPutsAllTilesOnTheFirstNode) {
  const RoutingTable table;
  EXPECT_EQ(table.node_of(TileId{7}), NodeId{0});
  EXPECT_TRUE(table.alive({TileId{7}, life(0)}));
}

}  // namespace
}  // namespace tessera
