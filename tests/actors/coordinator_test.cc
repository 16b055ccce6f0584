// A coordinator and nodes that come, are lost, and answer at moments that the harness hardly ever finds. The test is
// each of the nodes, and its part.
#include "tests/actors/coordinator_testing.h"

namespace tessera {
namespace {

TEST_F(Nodes, ThatAreAskedTwiceForTilesAnswerTwice) {
  start(begun_with(table_of({0, 0, 0, 0, 0, 0})), {&a_});
  tell_opened(a_);
  for (const caf::scoped_actor* late : {&b_, &c_}) {
    tell(a_, NodeJoined{handle_of(*late)});
    tell_opened(*late);
  }
  EXPECT_EQ(listen(a_).releases, 2);
  EXPECT_EQ(listen(b_).releases, 1);
  tell(a_, PartReleased{NodeId{0}, {}});
  tell(b_, PartReleased{NodeId{1}, {}});
  EXPECT_FALSE(listen(a_).table) << "one answer is still to come";
  tell(a_, PartReleased{NodeId{0}, {TileId{5}}});
  const auto table = listen(a_).table;
  ASSERT_TRUE(table);
  EXPECT_NE(table->node_of(TileId{5}), NodeId{0});
  EXPECT_EQ(table->peer_of(TileId{5}).incarnation, 1u);
  EXPECT_EQ(table->node_of(TileId{4}), NodeId{0});
}

TEST_F(Nodes, ThatAreLostAfterTheyHaveAnsweredHaveNoTilesAnyMore) {
  const Table table = table_of({0, 0, 0, 1, 1, 1});
  start(taken_over(), {&a_, &b_});
  tell_found(b_, 1, table);
  tell(a_, NodeLost{handle_of(b_)});
  tell_found(a_, 0, table);
  const auto next = listen(a_).table;
  ASSERT_TRUE(next);
  for (std::uint32_t t = 0; t < tiles; ++t) {
    EXPECT_EQ(next->node_of(TileId{t}), NodeId{0});
    EXPECT_EQ(next->peer_of(TileId{t}).incarnation > 0, t >= 3) << t;
  }
}

// Their parts may still speak: to whom they have no tiles, too.
TEST_F(Nodes, ThatAreLostAfterTheyHaveAnsweredKeepTheirNumber) {
  const Table table = table_of({0, 0, 0, 0, 0, 0});
  start(taken_over(), {&a_, &b_});
  tell_found(b_, 1, table);
  tell(a_, NodeLost{handle_of(b_)});
  tell_found(a_, 0, table);
  tell(a_, NodeJoined{handle_of(c_)});
  const auto open = listen(c_).open;
  ASSERT_TRUE(open);
  EXPECT_EQ(open->node, NodeId{2});
}

}  // namespace
}  // namespace tessera
