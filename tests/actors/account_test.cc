#include "actors/account.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

namespace tessera {
namespace {

using Time = Account::Time;
using std::chrono::seconds;

ShareProgress said(std::uint64_t begun, std::uint64_t stored) {
  ShareProgress p;
  p.tiles_begun = begun;
  p.weight_begun = 10 * begun;
  p.tiles_stored = stored;
  p.memory_bytes = 100;
  p.updates_sent = 7;
  p.spans.resize(1);
  p.mail.resize(1);
  return p;
}

TEST(Account, AddsUpWhatNodesSaidLast) {
  Account account(Time{});
  account.heard(NodeId{0}, said(1, 0), 2);
  account.heard(NodeId{1}, said(5, 2), 2);
  account.heard(NodeId{0}, said(3, 1), 2);
  const RunProgress now = account.progress({{"a", 4}, {"b", 6}});
  EXPECT_EQ(now.sum.tiles_begun, 8u);
  EXPECT_EQ(now.sum.weight_begun, 80u);
  EXPECT_EQ(now.sum.tiles_stored, 3u);
  EXPECT_EQ(now.sum.updates_sent, 14u);
  ASSERT_EQ(now.nodes.size(), 2u);
  EXPECT_EQ(now.nodes[0], (NodeProgress{"a", 4, 3, 1, 100, false}));
  EXPECT_EQ(now.nodes[1], (NodeProgress{"b", 6, 5, 2, 100, false}));
}

TEST(Account, TellsSpansAndMailOnce) {
  Account account(Time{});
  account.heard(NodeId{0}, said(1, 0), 1);
  account.heard(NodeId{0}, said(2, 0), 1);
  EXPECT_TRUE(account.has_untold());
  const RunProgress first = account.progress({{}});
  EXPECT_EQ(first.sum.spans.size(), 2u);
  EXPECT_EQ(first.sum.mail.size(), 2u);
  EXPECT_FALSE(account.has_untold());
  const RunProgress second = account.progress({{}});
  EXPECT_TRUE(second.sum.spans.empty());
  EXPECT_EQ(second.sum.tiles_begun, 2u);
  EXPECT_TRUE(second.nodes.empty()) << "one without a name is not told of by itself";
}

// What it has stored stays so; the rest others do again.
TEST(Account, CountsOfALostNodeWhatItHasStored) {
  Account account(Time{});
  account.heard(NodeId{1}, said(5, 2), 2);
  account.node_lost();
  const RunProgress now = account.progress({{"a", 1}, {"b", 5, true, false}, {"c", 1, true, true}});
  EXPECT_EQ(now.sum.tiles_begun, 2u);
  EXPECT_EQ(now.sum.weight_begun, 0u);
  EXPECT_EQ(now.sum.memory_bytes, 0u);
  EXPECT_EQ(now.nodes_lost, 1u);
  EXPECT_TRUE(now.nodes[1].lost);
  EXPECT_FALSE(now.nodes[2].lost) << "it left in order";
}

TEST(Account, LetsAnEighthOfManyNodesSpeakFirst) {
  Account account(Time{});
  EXPECT_TRUE(account.heard(NodeId{0}, {}, 7));
  account.progress({});
  for (std::uint32_t n = 0; n < 3; ++n) EXPECT_FALSE(account.heard(NodeId{n}, {}, 32));
  EXPECT_TRUE(account.heard(NodeId{3}, {}, 32));
}

TEST(Account, TakesTheTimeOfEachStage) {
  Account account(Time{});
  account.start(Time{seconds(1)}, false);
  EXPECT_EQ(account.step(), RunStep::beginning);
  account.all_have_begun(Time{seconds(3)});
  account.all_have_begun(Time{seconds(4)});  // a node that came late, too
  EXPECT_EQ(account.step(), RunStep::exchanging);
  account.is_quiet(Time{seconds(6)});
  EXPECT_EQ(account.step(), RunStep::ending);
  account.is_not_quiet();  // a node is lost while tiles settle
  EXPECT_EQ(account.step(), RunStep::exchanging);
  account.is_quiet(Time{seconds(8)});
  const RunEnded end = account.end(Time{seconds(9)}, 5);
  ASSERT_EQ(end.stages.size(), 1u);
  EXPECT_EQ(end.stages[0].begin_us, 2'000'000u);
  EXPECT_EQ(end.stages[0].exchange_us, 5'000'000u);
  EXPECT_EQ(end.stages[0].end_us, 1'000'000u);
  EXPECT_EQ(end.waves, 5u);
}

TEST(Account, OfASettledRunHasTheLastStageAlone) {
  Account account(Time{});
  account.start(Time{seconds(2)}, true);
  EXPECT_EQ(account.step(), RunStep::ending);
  const RunEnded end = account.end(Time{seconds(5)}, 0);
  EXPECT_EQ(end.stages[0].begin_us + end.stages[0].exchange_us, 0u);
  EXPECT_EQ(end.stages[0].end_us, 3'000'000u);
}

TEST(Account, EachStageHasTimesOfItsOwn) {
  Account account(Time{});
  account.start(Time{seconds(1)}, false);
  account.all_have_begun(Time{seconds(3)});
  account.is_quiet(Time{seconds(6)});
  account.begin_stage(Time{seconds(10)});
  EXPECT_EQ(account.step(), RunStep::beginning);
  EXPECT_EQ(account.progress({}).stage, 1u);
  account.all_have_begun(Time{seconds(11)});
  account.is_quiet(Time{seconds(13)});
  const RunEnded end = account.end(Time{seconds(20)}, 2);
  ASSERT_EQ(end.stages.size(), 2u);
  EXPECT_EQ(end.stages[0].end_us, 4'000'000u);
  EXPECT_EQ(end.stages[1].begin_us, 1'000'000u);
  EXPECT_EQ(end.stages[1].exchange_us, 2'000'000u);
  EXPECT_EQ(end.stages[1].end_us, 7'000'000u);
}

TEST(Account, AddsUpAtTheEnd) {
  Account account(Time{});
  ShareEnded a, b;
  a.items.sent = 3, a.hops = 4, a.sleeps = 1, a.begin_us = 10, a.most_received = 9;
  b.items.sent = 5, b.hops = 2, b.sleeps = 2, b.begin_us = 20, b.most_received = 8;
  account.ended(a);
  account.ended(b);
  account.node_came();
  account.node_came();
  account.tiles_begin_again(6);
  const RunEnded end = account.end(Time{}, 0);
  EXPECT_EQ(end.sum.items.sent, 8u);
  EXPECT_EQ(end.sum.hops, 4u);
  EXPECT_EQ(end.sum.sleeps, 3u);
  EXPECT_EQ(end.sum.begin_us, 30u);
  EXPECT_EQ(end.sum.most_received, 9u);
  EXPECT_EQ(end.nodes, 2u);
  EXPECT_EQ(end.tiles_again, 6u);
}

}  // namespace
}  // namespace tessera
