// A coordinator and nodes that come, are lost, and answer at moments that the harness hardly ever finds. The test is
// each of the nodes, and its share.
#include <utility>
#include <vector>

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
  tell(a_, ShareReleased{NodeId{0}, {}});
  tell(b_, ShareReleased{NodeId{1}, {}});
  EXPECT_FALSE(listen(a_).table) << "one answer is still to come";
  tell(a_, ShareReleased{NodeId{0}, {TileId{5}}});
  const auto table = listen(a_).table;
  ASSERT_TRUE(table);
  EXPECT_NE(table->node_of(TileId{5}), NodeId{0});
  EXPECT_EQ(table->peer_of(TileId{5}).incarnation.number, 1u);
  EXPECT_EQ(table->node_of(TileId{4}), NodeId{0});
}

TEST_F(Nodes, ThatAreLostAfterTheyHaveAnsweredHaveNoTilesAnyMore) {
  const RoutingTable table = table_of({0, 0, 0, 1, 1, 1});
  start(taken_over(), {&a_, &b_});
  tell_found(b_, 1, table);
  tell(a_, NodeLost{handle_of(b_)});
  tell_found(a_, 0, table);
  const auto next = listen(a_).table;
  ASSERT_TRUE(next);
  for (std::uint32_t t = 0; t < tiles; ++t) {
    EXPECT_EQ(next->node_of(TileId{t}), NodeId{0});
    EXPECT_EQ(next->peer_of(TileId{t}).incarnation > Incarnation(), t >= 3) << t;
  }
}

// Their shares may still speak: to whom they have no tiles, too.
TEST_F(Nodes, ThatAreLostAfterTheyHaveAnsweredKeepTheirNumber) {
  const RoutingTable table = table_of({0, 0, 0, 0, 0, 0});
  start(taken_over(), {&a_, &b_});
  tell_found(b_, 1, table);
  tell(a_, NodeLost{handle_of(b_)});
  tell_found(a_, 0, table);
  tell(a_, NodeJoined{handle_of(c_)});
  const auto open = listen(c_).open;
  ASSERT_TRUE(open);
  EXPECT_EQ(open->node, NodeId{2});
}

class Stages : public Nodes {
 protected:
  void all_is_quiet(std::uint32_t epoch) {
    tell(a_, ShareIdle{NodeId{0}});
    tell(b_, ShareIdle{NodeId{1}});
    for (int i = 0; i < 2; ++i) {
      ++wave_;
      tell(a_, ShareTally{NodeId{0}, {{}, epoch}, Wave{wave_}, true, 4, 4});
      tell(b_, ShareTally{NodeId{1}, {{}, epoch}, Wave{wave_}, true, 5, 5});
      tell(a_, ShareIdle{NodeId{0}});
      tell(b_, ShareIdle{NodeId{1}});
    }
    tell(a_, ShareSettled{NodeId{0}, {{}, epoch}});
    tell(b_, ShareSettled{NodeId{1}, {{}, epoch}});
  }
  void all_come_to_the_end(std::uint32_t epoch, std::uint32_t stage) {
    for (std::uint32_t t = 0; t < tiles; ++t) tell(t < 3 ? a_ : b_, TileDone{stage, {TileId{t}, {}}, 0});
    tell(a_, ShareCollected{NodeId{0}, {{}, epoch}});
    tell(b_, ShareCollected{NodeId{1}, {{}, epoch}});
  }
  // What the job is settled in, as it is written down.
  std::vector<std::pair<std::uint32_t, bool>> marks_;

  void start_both() {
    CoordinatorOptions two = begun_with(table_of({0, 0, 0, 1, 1, 1}));
    two.stages = 2;
    two.mark_settled = [this](std::uint32_t stage, bool settled) {
      marks_.emplace_back(stage, settled);
      return success();
    };
    start(std::move(two), {&a_, &b_});
    tell_opened(a_);
    tell_opened(b_);
  }

 private:
  std::uint64_t wave_ = 0;
};

TEST_F(Stages, FollowEachOther) {
  start_both();
  all_is_quiet(0);
  EXPECT_FALSE(listen(a_).table);
  all_come_to_the_end(0, 0);
  const auto next = listen(a_).table;
  ASSERT_TRUE(next);
  EXPECT_EQ(next->stage, 1u);
  EXPECT_EQ(next->epoch, (Epoch{{}, 1}));
  EXPECT_FALSE(owner_.end);
  all_is_quiet(1);
  all_come_to_the_end(1, 1);
  ShareEnded end;
  tell(a_, end);
  end.node = NodeId{1};
  tell(b_, end);
  ASSERT_TRUE(owner_.end);
  EXPECT_FALSE(owner_.end->failure);
  EXPECT_EQ(owner_.end->stages.size(), 2u);
  const std::vector<std::pair<std::uint32_t, bool>> expected{{0, false}, {0, true}, {1, false}, {1, true}};
  EXPECT_EQ(marks_, expected);
}

// A node that is slow to say it, and is lost: its tiles are not at the end of the stage that runs.
TEST_F(Stages, WhatWasStoredInOneIsNotStoredInTheNext) {
  start_both();
  all_is_quiet(0);
  all_come_to_the_end(0, 0);
  ASSERT_TRUE(listen(a_).table);
  tell(b_, TileDone{0, {TileId{4}, {}}, 0});
  tell(a_, NodeLost{handle_of(b_)});
  const auto next = listen(a_).table;
  ASSERT_TRUE(next);
  for (std::uint32_t t = 0; t < tiles; ++t) EXPECT_EQ(next->node_of(TileId{t}), NodeId{0}) << t;
}

}  // namespace
}  // namespace tessera
