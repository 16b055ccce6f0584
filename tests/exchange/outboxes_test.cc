// What a share sends to several nodes, owes to them, and keeps until it knows more.
#include "src/exchange/outboxes.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <utility>
#include <vector>

#include "src/base/files/temporary.h"

namespace tessera {
namespace {

constexpr NodeId a{1}, b{2};

Update update(std::uint32_t number, std::size_t bytes = 100) {
  Update out;
  out.from.tile = TileId{number};
  out.message.resize(bytes);
  return out;
}

const std::uint64_t one = Outbox::bytes_of(update(0));

TEST(Outboxes, SendToEachNodeWithinAWindowOfItsOwn) {
  Outboxes outboxes({.window_bytes = 2 * one, .packet_bytes = 2 * one, .memory_bytes = 100 * one}, {});
  for (std::uint32_t n = 0; n < 3; ++n) ASSERT_TRUE(outboxes.add(a, update(n)));
  ASSERT_TRUE(outboxes.add(b, update(9)));
  EXPECT_EQ(outboxes.next(a).value().size(), 2u);
  EXPECT_TRUE(outboxes.next(a).value().empty()) << "the window is full";
  EXPECT_EQ(outboxes.next(b).value().at(0).from.tile, TileId{9});
  EXPECT_EQ(outboxes.waiting_bytes(), one);
  EXPECT_EQ(outboxes.counts().packets, 2u);
  EXPECT_EQ(outboxes.counts().bytes, 3 * one);
  EXPECT_TRUE(outboxes.taken(a, 2 * one));
  EXPECT_EQ(outboxes.next(a).value().size(), 1u);
  EXPECT_FALSE(outboxes.taken(NodeId{7}, one)) << "nothing was sent there";
}

TEST(Outboxes, ForgetWhatWaitsForNodesWithoutAShare) {
  const auto folder = TemporaryFolder::make();
  const std::filesystem::path scratch = folder.value().path();
  Outboxes outboxes({.window_bytes = one, .packet_bytes = one, .memory_bytes = 0}, scratch);
  ASSERT_TRUE(outboxes.add(a, update(0)));
  ASSERT_TRUE(outboxes.add(b, update(1)));
  EXPECT_FALSE(std::filesystem::is_empty(scratch));
  outboxes.clear_unless([](NodeId node) { return node == b; });
  EXPECT_TRUE(outboxes.next(a).value().empty());
  EXPECT_EQ(outboxes.waiting_bytes(), one);
  outboxes.clear();
  EXPECT_EQ(outboxes.waiting_bytes(), 0u);
  EXPECT_TRUE(std::filesystem::is_empty(scratch));
}

TEST(OwedCredit, IsGivenWhenAQuarterOfTheWindowIsOwed) {
  OwedCredit owed;
  owed.note_window(a, 400);
  EXPECT_FALSE(owed.add(a, 60));
  EXPECT_TRUE(owed.add(a, 40));
  EXPECT_TRUE(owed.add(a, 1)) << "it was not given yet";
  EXPECT_EQ(owed.give(a), 101u);
  EXPECT_EQ(owed.give(a), 0u);
  EXPECT_FALSE(owed.add(a, 60));
}

TEST(EarlyMail, IsKeptInOrderUpToWhatNodesSend) {
  EarlyMail early;
  EXPECT_TRUE(early.keep(a, update(0), 2));
  EXPECT_TRUE(early.keep(b, update(1), 2));
  EXPECT_EQ(early.bytes(), 2 * one);
  const auto kept = early.take();
  ASSERT_EQ(kept.size(), 2u);
  EXPECT_EQ(kept[1].from, b);
  EXPECT_EQ(kept[1].update.from.tile, TileId{1});
  EXPECT_EQ(early.bytes(), 0u);
  EXPECT_TRUE(early.take().empty());
}

}  // namespace
}  // namespace tessera
