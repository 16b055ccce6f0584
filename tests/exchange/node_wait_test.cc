#include "src/exchange/node_wait.h"

#include <gtest/gtest.h>

namespace tessera {
namespace {

TEST(NodeWait, IsInVainWhenNoNodeHasCome) {
  NodeWait wait;
  EXPECT_FALSE(wait.has_waited());
  const auto number = wait.begin(error(Errc::internal, "the last node is lost"));
  EXPECT_TRUE(wait.has_waited());
  EXPECT_FALSE(wait.time_is_up(number, false)) << "a node has come";
  const auto missed = wait.time_is_up(number, true);
  ASSERT_TRUE(missed);
  EXPECT_EQ(missed->where, "the last node is lost");
}

TEST(NodeWait, CountsFromTheLastLoss) {
  NodeWait wait;
  const auto first = wait.begin(error(Errc::internal, "first"));
  const auto second = wait.begin(error(Errc::internal, "second"));
  EXPECT_FALSE(wait.time_is_up(first, true));
  wait.note_loss();
  EXPECT_FALSE(wait.time_is_up(second, true));
}

TEST(NodeWait, ForRoomIsInVainThoughNodesAreThere) {
  NodeWait wait;
  EXPECT_TRUE(wait.begin_without_room());
  const auto number = wait.begin(error(Errc::memory, "no room"));
  EXPECT_FALSE(wait.begin_without_room()) << "the job waits already";
  wait.has_room();
  EXPECT_FALSE(wait.time_is_up(number, false));
  EXPECT_TRUE(wait.begin_without_room());
  EXPECT_EQ(wait.time_is_up(number, false)->code, Errc::memory);
}

}  // namespace
}  // namespace tessera
