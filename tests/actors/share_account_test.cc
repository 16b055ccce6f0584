#include "actors/share_account.h"

#include <gtest/gtest.h>

#include <cstdint>

namespace tessera {
namespace {

using Time = ShareAccount::Time;
using std::chrono::milliseconds;

TileReport report(Work work, std::uint64_t sent, std::uint64_t processed) {
  TileReport made;
  made.span.work = work;
  made.span.begin_us = 10;
  made.span.end_us = 15;
  made.sent = sent;
  made.processed = processed;
  made.updates = sent;
  made.items.sent = 2 * sent;
  made.hops = 3;
  return made;
}

TEST(ShareAccount, AddsUpWhatTilesHaveToldLast) {
  ShareAccount account(NodeId{4}, milliseconds(100), 0, Time{});
  ShareAccount::Tile a, b;
  account.note(a, report(Work::begin, 5, 1));
  account.note(b, report(Work::begin, 7, 2));
  account.note(a, report(Work::step, 6, 4));
  EXPECT_EQ(account.totals(), (Totals{13, 6}));
  EXPECT_EQ(a.microseconds, 10u);
  account.end(2, {});
  EXPECT_EQ(account.sum().node, NodeId{4});
  EXPECT_EQ(account.sum().updates, 13u);
  EXPECT_EQ(account.sum().items.sent, 26u);
  EXPECT_EQ(account.sum().hops, 3u);
  EXPECT_EQ(account.sum().begin_us, 10u);
  EXPECT_EQ(account.sum().exchange_us, 5u);
  EXPECT_EQ(account.sum().sleeps, 2u);
}

TEST(ShareAccount, CountsATileThatHasLeftNoMore) {
  ShareAccount account(NodeId{0}, milliseconds(100), 0, Time{});
  ShareAccount::Tile tile;
  account.note(tile, Totals{5, 1});
  account.note(tile, Totals{});
  EXPECT_EQ(account.totals(), Totals{});
}

TEST(ShareAccount, IsDueAfterTheIntervalWhichGrowsWithTheNumberOfNodes) {
  ShareAccount account(NodeId{0}, milliseconds(100), 0, Time{});
  EXPECT_FALSE(account.is_due(Time{milliseconds(99)}, false, 2));
  EXPECT_TRUE(account.is_due(Time{milliseconds(100)}, false, 2));
  EXPECT_FALSE(account.is_due(Time{milliseconds(199)}, false, 2));
  EXPECT_FALSE(account.is_due(Time{milliseconds(250)}, false, 100));
  EXPECT_TRUE(account.is_due(Time{milliseconds(250)}, true, 100));
  EXPECT_TRUE(account.is_due(Time{milliseconds(450)}, false, 100));
}

TEST(ShareAccount, IsDueWhenThereAreManySpans) {
  ShareAccount account(NodeId{0}, milliseconds(100), 0, Time{});
  ShareAccount::Tile tile;
  for (int n = 0; n < 1000; ++n) account.note(tile, report(Work::step, 0, 0));
  EXPECT_TRUE(account.is_due(Time{}, false, 2));
  account.forget_spans();
  EXPECT_TRUE(account.progress(0, 0, {}).spans.empty());
  EXPECT_FALSE(account.is_due(Time{}, false, 2));
}

// Of three tiles that an earlier process has stored, the node has done nothing.
TEST(ShareAccount, TellsTheProgressOfAStageAndTheWorkOfAll) {
  ShareAccount account(NodeId{0}, milliseconds(100), 3, Time{});
  account.tile_has_begun(10);
  account.tile_is_stored();
  EXPECT_EQ(account.progress(1, 70, {}).tiles_stored, 4u);
  EXPECT_EQ(account.work(3, 9).tiles_stored, 1u);
  account.begin_next_stage(3, 5);
  account.tile_has_begun(20);
  account.tile_has_begun(30);
  const ShareProgress& now = account.progress(1, 70, {});
  EXPECT_EQ(now.tiles_begun, 2u);
  EXPECT_EQ(now.weight_begun, 50u);
  EXPECT_EQ(now.tiles_stored, 0u);
  EXPECT_EQ(now.memory_bytes, 70u);
  const NodeWork work = account.work(0, 9);
  EXPECT_EQ(work.tiles_begun, 3u);
  EXPECT_EQ(work.weight_begun, 60u);
  EXPECT_EQ(work.tiles_stored, 1u);
  EXPECT_EQ(work.tiles_asleep, 1u);
  EXPECT_EQ(work.waiting_bytes, 9u);
  EXPECT_EQ(account.sum().sleeps, 5u);
}

}  // namespace
}  // namespace tessera
