// Tiles go where there is room for them, and away from a node whose scratch cannot be used.
#include "tests/actors/coordinator_testing.h"

namespace tessera {
namespace {

// Tile 2 has ten points, the others one each; a node of so many bytes has room for tiles of as many.
CoordinatorOptions with_room(CoordinatorOptions options) {
  options.weights[2] = 10;
  options.weight_max = [](std::uint32_t, std::uint64_t bytes) { return bytes; };
  options.tile_in_words = [](std::uint64_t weight) {
    return "a tile of " + std::to_string(weight) + " points, which needs about 11 MiB";
  };
  return options;
}

TEST_F(Nodes, GetNoTileThatTheyHaveNoRoomFor) {
  start(with_room(taken_over()), {&a_, &b_, &c_});
  tell_none(a_, 1, "a");
  tell_none(b_, 10, "b");
  tell_none(c_, 0, "c");
  const auto spec = listen(a_).open;
  ASSERT_TRUE(spec);
  const RoutingTable table = spec_from_bytes(spec->spec.get()).value().table;
  EXPECT_EQ(table.node_of(TileId{2}), NodeId{1});
  for (std::uint32_t t = 0; t < tiles; ++t) EXPECT_NE(table.node_of(TileId{t}), NodeId{2}) << t;
}

TEST_F(Nodes, AreWaitedForWhileNobodyHasRoomForATile) {
  start(with_room(taken_over()), {&a_});
  tell_none(a_, 9, "a");
  EXPECT_FALSE(listen(a_).open);
  EXPECT_NE(owner_.lines.find("no node has enough memory for a tile of 10 points, which needs about 11 MiB: the most "
                              "that a job gets is 0 MiB, on node a: the job waits 3600 s for another node"),
            std::string::npos)
      << owner_.lines;
  tell(a_, NodeJoined{handle_of(b_)});
  tell_none(b_, 10, "b");
  EXPECT_TRUE(listen(a_).open);
  const auto open = listen(b_).open;
  ASSERT_TRUE(open);
  EXPECT_EQ(spec_from_bytes(open->spec.get()).value().table.node_of(TileId{2}), open->node);
}

TEST_F(Nodes, AreNotWaitedForLongerThanTheGrace) {
  start(with_room(taken_over()), {&a_, &b_});
  tell_none(a_, 9, "a");
  tell_none(b_, 8, "b");
  tell(a_, NodeLost{handle_of(b_)});
  EXPECT_FALSE(owner_.end);
  scheduler_.advance_time(std::chrono::seconds(3600));
  run();
  ASSERT_TRUE(owner_.end);
  EXPECT_EQ(owner_.end->failure.code, static_cast<std::uint8_t>(Errc::memory));
  EXPECT_NE(owner_.end->failure.text.find("a tile of 10 points"), std::string::npos) << owner_.end->failure.text;
}

// The only one with room is lost in the middle: the others go on, nothing is believed quiet, and its tile waits.
TEST_F(Nodes, WithoutRoomDoNotEndAJob) {
  start(with_room(taken_over()), {&a_, &b_});
  tell_none(a_, 1, "a");
  tell_none(b_, 10, "b");
  tell_opened(a_, 1, "a");
  tell_opened(b_, 10, "b");
  tell(a_, NodeLost{handle_of(b_)});
  const auto table = listen(a_).table;
  ASSERT_TRUE(table);
  for (std::uint32_t t = 0; t < tiles; ++t) EXPECT_EQ(table->node_of(TileId{t}), NodeId{t == 2 ? 1U : 0U}) << t;
  tell(a_, ShareIdle{NodeId{0}});
  tell(a_, ShareTally{NodeId{0}, table->epoch, 1, true, 0, 0});
  tell(a_, ShareTally{NodeId{0}, table->epoch, 2, true, 0, 0});
  EXPECT_LE(listen(a_).probes, 1);
  tell(a_, NodeJoined{handle_of(c_)});
  tell_opened(c_, 10, "c");
  EXPECT_EQ(listen(a_).releases, 1);
  tell(a_, ShareReleased{NodeId{0}, {}});
  const auto next = listen(c_).table;
  ASSERT_TRUE(next);
  EXPECT_EQ(next->node_of(TileId{2}), NodeId{2});
}

TEST_F(Nodes, WithoutRoomForAnyTileAreNotGivenWorkOfOthers) {
  start(with_room(taken_over()), {&a_});
  tell_none(a_, 10, "a");
  tell_opened(a_, 10, "a");
  tell(a_, NodeJoined{handle_of(b_)});
  tell_opened(b_, 0, "b");
  const Heard heard = listen(a_);
  EXPECT_EQ(heard.releases, 0);
  EXPECT_FALSE(heard.table);
}

TEST_F(Nodes, WhoseScratchCannotBeUsedAreDoneWithout) {
  start(begun_with(table_of({0, 0, 0, 1, 1, 1})), {&a_, &b_});
  tell_opened(a_, 0, "a");
  tell_opened(b_, 0, "b");
  ShareEnded ended;
  ended.node = NodeId{1};
  ended.of_node = true;
  ended.failure = failure_of(error(Errc::io, "/scratch/x: cannot write: No space left on device"));
  tell(b_, std::move(ended));
  EXPECT_FALSE(owner_.end);
  const auto table = listen(a_).table;
  ASSERT_TRUE(table);
  for (std::uint32_t t = 0; t < tiles; ++t) EXPECT_EQ(table->node_of(TileId{t}), NodeId{0});
  EXPECT_NE(owner_.lines.find("node b is lost: it cannot use its scratch folder (node b: /scratch/x: cannot write"),
            std::string::npos)
      << owner_.lines;
  // The last one's failure is the job's.
  ShareEnded last;
  last.node = NodeId{0};
  last.of_node = true;
  last.failure = failure_of(error(Errc::io, "/scratch/y: cannot write: No space left on device"));
  tell(a_, std::move(last));
  ASSERT_TRUE(owner_.end);
  EXPECT_EQ(owner_.end->failure.code, static_cast<std::uint8_t>(Errc::io));
  EXPECT_EQ(owner_.end->failure.text, "node a: /scratch/y: cannot write: No space left on device");
}

}  // namespace
}  // namespace tessera
