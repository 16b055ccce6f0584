#include "src/exchange/placements.h"

#include <gtest/gtest.h>

#include <map>
#include <utility>
#include <vector>

namespace tessera {
namespace {

std::vector<TileId> ids(const std::vector<std::uint32_t>& values) {
  std::vector<TileId> tiles;
  for (const std::uint32_t value : values) tiles.push_back(TileId{value});
  return tiles;
}

// Six tiles of weight 1, on nodes 0 and 1.
class SixTiles : public ::testing::Test {
 protected:
  Placements make(Term term = {}) const {
    PlacementOptions options{std::vector<std::uint64_t>(6, 1), ids({0, 1, 2, 3, 4, 5}), term};
    RoutingTable table;
    for (const std::uint32_t node : {0, 0, 0, 1, 1, 1}) table.nodes.push_back(NodeId{node});
    table.incarnations.assign(6, {});
    return {std::move(options), std::move(table)};
  }
  static std::map<std::uint32_t, std::uint32_t> where(const std::vector<Placement>& changes) {
    std::map<std::uint32_t, std::uint32_t> where;
    for (const Placement& change : changes) where[change.tile.value] = change.node.value;
    return where;
  }
  static bool all_live(NodeId) { return true; }
};

TEST_F(SixTiles, OfALostNodeBeginAgainElsewhereButForThoseThatAreStored) {
  Placements placements = make();
  EXPECT_TRUE(placements.store(TileId{4}));
  EXPECT_FALSE(placements.store(TileId{4})) << "by a node that was lost, too";
  EXPECT_TRUE(placements.complete());
  EXPECT_EQ(placements.lose(NodeId{1}), 2u);
  EXPECT_FALSE(placements.complete());
  EXPECT_EQ(placements.homeless(), ids({3, 5}));
  const auto placed = placements.place({{NodeId{0}}}, [](NodeId node) { return node == NodeId{0}; });
  EXPECT_EQ(placed.again, 2u);
  EXPECT_EQ(where(placed.changes), (std::map<std::uint32_t, std::uint32_t>{{3, 0}, {5, 0}}));
  const RoutingTable& next = placements.change(placed.changes);
  EXPECT_EQ(next.epoch, (Epoch{{}, 1}));
  EXPECT_EQ(next.peer_of(TileId{3}).incarnation, (Incarnation{{}, 1}));
  EXPECT_EQ(next.node_of(TileId{4}), NodeId{1}) << "it is stored";
  EXPECT_TRUE(placements.complete());
}

TEST_F(SixTiles, AreHomelessWhenTheirNodesAreGoneOrHaveGivenThemUp) {
  Placements placements = make();
  EXPECT_EQ(placements.release_homeless(all_live), 0u);
  placements.store(TileId{5});
  const auto first_lives = [](NodeId node) { return node == NodeId{0}; };
  EXPECT_EQ(placements.release_homeless(first_lives, {false, true, false, true, false, false}), 3u);
  EXPECT_EQ(placements.homeless(), ids({1, 3, 4})) << "tile 5 is stored";
  EXPECT_FALSE(placements.complete());
}

TEST_F(SixTiles, AreAskedForWhenANodeComes) {
  Placements placements = make();
  const std::vector<Host> hosts{{NodeId{0}}, {NodeId{1}}, {NodeId{2}}};
  const auto requests = placements.ask_for(NodeId{2}, hosts);
  ASSERT_EQ(requests.size(), 2u);
  EXPECT_EQ(requests[0].node, NodeId{0});
  EXPECT_EQ(requests[0].weight, 1u) << "each of three nodes is to have two tiles of six";
  EXPECT_EQ(requests[1].node, NodeId{1});
  EXPECT_TRUE(placements.awaits());
  EXPECT_TRUE(placements.take_answer(NodeId{0}, ids({2})));
  EXPECT_TRUE(placements.take_answer(NodeId{1}, {}));
  EXPECT_FALSE(placements.awaits());
}

TEST_F(SixTiles, ThatWereGivenUpGoToWhoeverCameLate) {
  Placements placements = make();
  placements.come_late(NodeId{2});
  for (const NodeId node : {NodeId{0}, NodeId{1}}) placements.ask(node);
  EXPECT_TRUE(placements.awaits());
  EXPECT_TRUE(placements.take_answer(NodeId{0}, ids({2})));
  EXPECT_FALSE(placements.take_answer(NodeId{0}, ids({1}))) << "it was asked once";
  EXPECT_TRUE(placements.awaits());
  EXPECT_TRUE(placements.take_answer(NodeId{1}, ids({5})));
  EXPECT_FALSE(placements.awaits());
  const std::vector<Host> hosts{{NodeId{0}}, {NodeId{1}}, {NodeId{2}}};
  const auto placed = placements.place(hosts, all_live);
  EXPECT_EQ(placed.again, 0u);
  EXPECT_EQ(where(placed.changes), (std::map<std::uint32_t, std::uint32_t>{{2, 2}, {5, 2}}));
}

TEST_F(SixTiles, OfANodeThatIsLostBeforeItAnswersAreLostWithIt) {
  Placements placements = make();
  placements.ask(NodeId{1});
  EXPECT_EQ(placements.lose(NodeId{1}), 3u);
  EXPECT_FALSE(placements.awaits());
  EXPECT_FALSE(placements.take_answer(NodeId{1}, ids({5})));
  EXPECT_EQ(placements.homeless(), ids({3, 4, 5}));
}

TEST_F(SixTiles, ThatAreHandedOverGoOnElsewhere) {
  Placements placements = make();
  EXPECT_TRUE(placements.begin_handing(NodeId{0}));
  EXPECT_FALSE(placements.begin_handing(NodeId{0}));
  EXPECT_TRUE(placements.hands_over(NodeId{0}));
  EXPECT_TRUE(placements.awaits());
  placements.release(ids({1}));  // given up before
  EXPECT_TRUE(placements.end_handing(NodeId{0}));
  EXPECT_FALSE(placements.end_handing(NodeId{0}));
  const auto placed = placements.place({{NodeId{1}}}, [](NodeId node) { return node == NodeId{1}; });
  EXPECT_EQ(placed.again, 0u);
  EXPECT_EQ(where(placed.changes).size(), 3u);
}

TEST_F(SixTiles, WaitWhereNobodyHasRoom) {
  Placements placements = make();
  placements.lose(NodeId{1});
  const std::vector<Host> small{{NodeId{0}, 1, 0}};
  const auto lives = [](NodeId node) { return node != NodeId{1}; };
  EXPECT_TRUE(placements.place(small, lives).changes.empty());
  EXPECT_EQ(placements.homeless().size(), 3u);
  EXPECT_EQ(placements.place({{NodeId{2}}}, lives).changes.size(), 3u);
  EXPECT_TRUE(placements.complete());
}

TEST_F(SixTiles, OfAHigherTermHaveHigherEpochsAndIncarnations) {
  Placements placements = make(Term{3});
  placements.lose(NodeId{1});
  const RoutingTable& next =
      placements.change(placements.place({{NodeId{0}}}, [](NodeId n) { return n == NodeId{0}; }).changes);
  EXPECT_EQ(next.epoch, (Epoch{Term{3}, 0}));
  EXPECT_EQ(next.peer_of(TileId{5}).incarnation, (Incarnation{Term{3}, 0}));
  EXPECT_EQ(next.peer_of(TileId{0}).incarnation, (Incarnation{{}, 0}));
  EXPECT_EQ(placements.change({}).epoch, (Epoch{Term{3}, 1}));
}

TEST_F(SixTiles, AreSharedOutAnewInTheNextStage) {
  Placements placements = make();
  for (std::uint32_t t = 0; t < 6; ++t) placements.store(TileId{t});
  const auto lives = [](NodeId node) { return node != NodeId{1}; };
  const auto changes = placements.begin_next_stage({{NodeId{0}}, {NodeId{2}}}, lives);
  EXPECT_EQ(where(changes), (std::map<std::uint32_t, std::uint32_t>{{3, 2}, {4, 2}, {5, 2}}));
  const RoutingTable& next = placements.change(changes);
  EXPECT_EQ(next.stage, 1u);
  EXPECT_EQ(next.peer_of(TileId{0}).incarnation, (Incarnation{{}, 0})) << "it stays where it is";
  EXPECT_EQ(next.peer_of(TileId{3}).incarnation, (Incarnation{{}, 1}));
  EXPECT_FALSE(placements.is_stored(TileId{0}));
}

TEST_F(SixTiles, WaitInTheNextStageWhenAllNodesAreToLeave) {
  Placements placements = make();
  EXPECT_TRUE(placements.begin_next_stage({}, all_live).empty());
  EXPECT_EQ(placements.homeless().size(), 6u);
}

TEST_F(SixTiles, OfOneNodeHaveATableInTheNextStage) {
  Placements placements({std::vector<std::uint64_t>(2, 1), ids({0, 1}), {}}, RoutingTable());
  const auto changes = placements.begin_next_stage({{NodeId{0}}}, all_live);
  EXPECT_TRUE(changes.empty());
  EXPECT_EQ(placements.change(changes).nodes, std::vector<NodeId>(2, NodeId{0}));
}

TEST_F(SixTiles, AreCountedByNode) {
  const Placements placements = make();
  EXPECT_EQ(placements.held(2), (std::vector<std::uint64_t>{3, 3}));
  EXPECT_EQ(placements.tiles(1), (std::vector<std::uint32_t>{3})) << "of a node that there is";
}

}  // namespace
}  // namespace tessera
