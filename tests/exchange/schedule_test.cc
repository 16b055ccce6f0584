#include "src/exchange/schedule.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

namespace tessera {
namespace {

using Mode = Schedule::Mode;

ScheduleOptions options(std::uint32_t threads, std::uint64_t memory) {
  return {.threads = threads, .memory_bytes = memory, .begin_bytes = 10, .collect_bytes = 10, .mail_growth = 1};
}

// "begin 0, sleep 1": everything that is granted now.
std::string granted(Schedule& schedule) {
  std::string text;
  while (const auto permit = schedule.next()) {
    text += (text.empty() ? "" : ", ") + std::string(name_of(permit->work)) + " " + std::to_string(permit->tile.value);
  }
  return text;
}

TEST(Schedule, GrantsAsManyAsThereAreThreadsAndBeginsEveryTileFirst) {
  Schedule schedule(options(2, 1000), {10, 0, 10, 10});
  EXPECT_EQ(granted(schedule), "begin 0, begin 2");
  schedule.note_mail(TileId{3}, {1, 50, 100});
  schedule.note_done(TileId{0}, Work::begin, 100, {1, 5, 10});
  EXPECT_EQ(granted(schedule), "begin 3") << "tile 0 has mail, but not all have begun";
  EXPECT_FALSE(schedule.all_begun());
  schedule.note_done(TileId{2}, Work::begin, 100, {});
  schedule.note_done(TileId{3}, Work::begin, 100, {1, 50, 100});
  EXPECT_TRUE(schedule.all_begun());
  EXPECT_EQ(granted(schedule), "step 3, step 0") << "most mail first";
  EXPECT_FALSE(schedule.idle());
  schedule.note_done(TileId{3}, Work::step, 100, {});
  schedule.note_done(TileId{0}, Work::step, 100, {});
  EXPECT_TRUE(schedule.idle());
}

TEST(Schedule, AsManyAgainAreGrantedAheadWhereTheyAreSmallAndNothingMustMakeRoom) {
  Schedule small(options(2, 50'000), {10, 10, 10, 10, 10});
  EXPECT_EQ(granted(small), "begin 0, begin 1, begin 2, begin 3");
  small.note_done(TileId{1}, Work::begin, 100, {});
  EXPECT_EQ(granted(small), "begin 4");
  Schedule large(options(1, 50'000), {10, 20, 10});
  EXPECT_EQ(granted(large), "begin 0") << "the next takes 200 bytes, more than the 256th part of the memory";
  large.note_done(TileId{0}, Work::begin, 100, {});
  EXPECT_EQ(granted(large), "begin 1, begin 2");
  for (const std::uint32_t t : {1u, 2u}) large.note_done(TileId{t}, Work::begin, 100, {1, 5, 10});
  large.enter(Mode::suspending);
  EXPECT_EQ(granted(large), "sleep 0") << "not more at once than there are threads";
  Schedule full(options(1, 50'000), {10, 10, 10});
  EXPECT_EQ(granted(full), "begin 0, begin 1");
  full.note_done(TileId{0}, Work::begin, 49'850, {});
  EXPECT_EQ(granted(full), "") << "there is no room for one that has no thread";
  full.note_done(TileId{1}, Work::begin, 100, {});
  EXPECT_EQ(granted(full), "sleep 0");
}

TEST(Schedule, AnEmptyUpdateIsProcessedToo) {
  Schedule schedule(options(1, 1000), {10});
  EXPECT_EQ(granted(schedule), "begin 0");
  schedule.note_done(TileId{0}, Work::begin, 100, {1, 0, 0});
  EXPECT_FALSE(schedule.idle());
  EXPECT_EQ(granted(schedule), "step 0");
}

// Mail that was moved to the disk waits, too, and takes no memory.
TEST(Schedule, CountsTheMemoryOfMailAndNotItsBytes) {
  Schedule schedule(options(1, 1000), {10, 10});
  EXPECT_EQ(granted(schedule), "begin 0");
  schedule.note_done(TileId{0}, Work::begin, 100, {9, 900, 20});
  EXPECT_EQ(schedule.memory(), 120u);
  EXPECT_EQ(granted(schedule), "begin 1");
  schedule.note_mail(TileId{0}, {10, 950, 30});
  schedule.note_done(TileId{1}, Work::begin, 50, {});
  EXPECT_EQ(schedule.memory(), 180u);
}

TEST(Schedule, MakesRoomByPuttingToSleepNoMoreTilesThanNeeded) {
  Schedule schedule(options(4, 350), {10, 10, 10, 20});
  EXPECT_EQ(granted(schedule), "begin 0, begin 1, begin 2");
  for (const std::uint32_t t : {0u, 1u, 2u}) schedule.note_done(TileId{t}, Work::begin, 100, {});
  // 300 held; the fourth wants 200: two must go, and what they free counts once, not again at every call.
  EXPECT_EQ(granted(schedule), "sleep 0, sleep 1");
  EXPECT_EQ(granted(schedule), "");
  schedule.note_done(TileId{0}, Work::sleep, 0, {});
  EXPECT_EQ(granted(schedule), "");
  schedule.note_done(TileId{1}, Work::sleep, 0, {});
  EXPECT_EQ(granted(schedule), "begin 3");
  EXPECT_EQ(schedule.memory(), 300u);
  EXPECT_EQ(schedule.asleep(), 2u);
}

TEST(Schedule, ATileWithMailSplaysBeforeAnotherIsPutToSleepForOneThatBegins) {
  Schedule schedule(options(1, 250), {10, 10, 10});
  EXPECT_EQ(granted(schedule), "begin 0");
  schedule.note_done(TileId{0}, Work::begin, 100, {});
  EXPECT_EQ(granted(schedule), "begin 1");
  schedule.note_mail(TileId{0}, {1, 5, 10});
  schedule.note_done(TileId{1}, Work::begin, 100, {1, 5, 10});
  EXPECT_EQ(granted(schedule), "step 1");
  schedule.note_done(TileId{1}, Work::step, 100, {});
  EXPECT_EQ(granted(schedule), "step 0");
  schedule.note_done(TileId{0}, Work::step, 100, {});
  EXPECT_EQ(granted(schedule), "sleep 0") << "it is farther from tile 2";
}

// What is asleep is woken in one sweep after the other, and not by what it has: each sweep brings a tile all that its
// neighbours have to say.
TEST(Schedule, TilesAsleepAreWokenInSweepsAlongTheirOrderAndBack) {
  Schedule schedule(options(1, 150), std::vector<std::uint64_t>(5, 10));
  std::string order;
  const auto work = [&](Work expected) {
    const auto permit = schedule.next();
    ASSERT_TRUE(permit);
    ASSERT_EQ(permit->work, expected);
    if (expected != Work::sleep) order += std::to_string(permit->tile.value);
    schedule.note_done(permit->tile, expected, expected == Work::sleep ? 0 : 100, {});
  };
  for (int t = 0; t < 5; ++t) {
    if (t > 0) work(Work::sleep);
    work(Work::begin);
  }
  EXPECT_EQ(std::exchange(order, ""), "01234");
  for (const std::uint32_t t : {0u, 1u, 3u}) schedule.note_mail(TileId{t}, {1, t, 0});
  for (int t = 0; t < 2; ++t) {
    work(Work::sleep);
    work(Work::step);
  }
  EXPECT_EQ(std::exchange(order, ""), "31") << "from the last one back";
  for (const std::uint32_t t : {2u, 4u}) schedule.note_mail(TileId{t}, {9, 90, 0});
  for (int t = 0; t < 3; ++t) {
    work(Work::sleep);
    work(Work::step);
  }
  EXPECT_EQ(order, "024") << "those it has passed wait until it comes again";
  EXPECT_TRUE(schedule.idle());
}

TEST(Schedule, ATileThatFitsNowhereWorksAloneRatherThanNever) {
  Schedule schedule(options(2, 50), {10, 10});
  EXPECT_EQ(granted(schedule), "begin 0");
  schedule.note_done(TileId{0}, Work::begin, 60, {});
  EXPECT_EQ(granted(schedule), "sleep 0");
  schedule.note_done(TileId{0}, Work::sleep, 0, {});
  EXPECT_EQ(granted(schedule), "begin 1");
}

TEST(Schedule, MailOfTilesThatSleepOrHaveNotBegunIsCounted) {
  Schedule schedule(options(1, 1000), {10, 10});
  schedule.note_mail(TileId{1}, {1, 10, 400});
  EXPECT_EQ(schedule.memory(), 400u);
  schedule.note_mail(TileId{1}, {2, 20, 800});
  EXPECT_EQ(schedule.memory(), 800u);
  schedule.note_mail(TileId{1}, {3, 30, 0});  // spilled
  EXPECT_EQ(schedule.memory(), 0u);
}

TEST(Schedule, CollectsWhatIsInMemoryFirstAndDropsWhatIsStored) {
  Schedule schedule(options(4, 10'000), {10, 10, 10});
  schedule.set_stored(TileId{1});
  EXPECT_EQ(granted(schedule), "begin 0, begin 1, begin 2");
  for (const std::uint32_t t : {0u, 1u, 2u}) schedule.note_done(TileId{t}, Work::begin, 100, {});
  EXPECT_TRUE(schedule.idle());
  schedule.enter(Mode::settling);
  EXPECT_EQ(granted(schedule), "settle 0, settle 1, settle 2");
  for (const std::uint32_t t : {0u, 1u, 2u}) schedule.note_done(TileId{t}, Work::settle, 100, {});
  EXPECT_TRUE(schedule.idle());
  schedule.enter(Mode::collecting);
  EXPECT_EQ(granted(schedule), "finish 0, drop 1, finish 2");
  schedule.note_done(TileId{1}, Work::drop, 0, {});
  schedule.note_done(TileId{0}, Work::finish, 0, {}, 70);
  schedule.note_done(TileId{2}, Work::finish, 0, {}, 70);
  EXPECT_EQ(schedule.memory(), 140u) << "meshes on their way count";
  EXPECT_FALSE(schedule.idle());
  schedule.note_stored(TileId{2});
  schedule.note_stored(TileId{0});
  EXPECT_EQ(schedule.memory(), 0u);
  EXPECT_TRUE(schedule.idle());
}

TEST(Schedule, NoMoreMeshesWaitForTheDiskThanThereAreThreadsUnlessTheyAreSmall) {
  const auto waiting = [](std::uint64_t mesh_bytes) {
    Schedule schedule(options(1, 16'000), std::vector<std::uint64_t>(12, 10));
    schedule.enter(Mode::collecting);  // settled before: the tiles are built and collected at once
    std::uint32_t n = 0;
    while (const auto permit = schedule.next()) {
      EXPECT_EQ(permit->work, Work::finish);
      schedule.note_done(permit->tile, Work::finish, 0, {}, mesh_bytes);
      ++n;
    }
    return n;
  };
  EXPECT_EQ(waiting(1200), 2u);
  EXPECT_EQ(waiting(200), 6u) << "a sixteenth of the memory and one more";
  EXPECT_EQ(waiting(10), 12u);
}

TEST(Schedule, AnInterruptedPartPutsEveryTileToSleepAndNothingElse) {
  Schedule schedule(options(1, 1000), {10, 10, 10});
  EXPECT_EQ(granted(schedule), "begin 0");
  schedule.note_done(TileId{0}, Work::begin, 100, {1, 5, 5});
  EXPECT_EQ(granted(schedule), "begin 1");
  schedule.enter(Mode::suspending);
  EXPECT_EQ(granted(schedule), "");
  schedule.note_done(TileId{1}, Work::begin, 100, {});
  EXPECT_EQ(granted(schedule), "sleep 1");
  schedule.note_done(TileId{1}, Work::sleep, 0, {});
  EXPECT_EQ(granted(schedule), "sleep 0");
  EXPECT_FALSE(schedule.idle());
  schedule.note_done(TileId{0}, Work::sleep, 0, {1, 5, 5});
  EXPECT_TRUE(schedule.idle()) << "the third tile need not begin";
}

TEST(Schedule, AnInterruptedPartLeavesNoMoreImagesThanItMay) {
  auto few = options(2, 1000);
  few.suspend_bytes = 150;
  Schedule schedule(few, {10, 10, 10});
  EXPECT_EQ(granted(schedule), "begin 0, begin 1");
  schedule.note_done(TileId{0}, Work::begin, 100, {});
  EXPECT_EQ(granted(schedule), "begin 2");
  schedule.note_done(TileId{1}, Work::begin, 60, {});
  schedule.enter(Mode::suspending);
  EXPECT_EQ(granted(schedule), "sleep 0");
  schedule.note_done(TileId{2}, Work::begin, 50, {});
  EXPECT_EQ(granted(schedule), "sleep 2");
  schedule.note_done(TileId{0}, Work::sleep, 0, {});
  EXPECT_FALSE(schedule.idle());
  schedule.note_done(TileId{2}, Work::sleep, 0, {});
  EXPECT_TRUE(schedule.idle()) << "the tile of 60 bytes is given up";
}

TEST(Schedule, WhatIsGivenUpIsNotWaitedFor) {
  Schedule schedule(options(2, 1000), {10, 10});
  EXPECT_EQ(granted(schedule), "begin 0, begin 1");
  schedule.enter(Mode::stopping);
  schedule.abandon(TileId{0});
  EXPECT_FALSE(schedule.idle());
  schedule.note_done(TileId{1}, Work::begin, 100, {});
  EXPECT_TRUE(schedule.idle());
}

TEST(Schedule, WhatIsGivenUpTakesNoMemory) {
  Schedule schedule(options(2, 1000), {10, 10, 10});
  EXPECT_EQ(granted(schedule), "begin 0, begin 1");
  schedule.note_done(TileId{0}, Work::begin, 100, {1, 5, 10});
  EXPECT_GT(schedule.memory(), 0U);
  schedule.abandon(TileId{1});  // while it works
  schedule.abandon(TileId{0});  // with mail
  EXPECT_EQ(schedule.memory(), 0U);
  schedule.note_mail(TileId{0}, {1, 5, 10});
  EXPECT_EQ(schedule.memory(), 0U);
  schedule.abandon(TileId{2});
  EXPECT_TRUE(schedule.idle());
  Schedule suspended(options(1, 1000), {10});
  EXPECT_EQ(granted(suspended), "begin 0");
  suspended.note_done(TileId{0}, Work::begin, 100, {});
  suspended.enter(Mode::suspending);
  EXPECT_EQ(granted(suspended), "sleep 0");
  suspended.abandon(TileId{0});  // while it falls asleep
  EXPECT_EQ(suspended.memory(), 0U);
  EXPECT_TRUE(suspended.idle());
}

TEST(Schedule, TilesThatComeLaterBeginBeforeAnybodySplays) {
  Schedule schedule(options(1, 1000), {0, 10, 0});
  EXPECT_EQ(granted(schedule), "begin 1");
  schedule.note_done(TileId{1}, Work::begin, 100, {1, 5, 10});
  schedule.add(TileId{0}, 10);
  EXPECT_FALSE(schedule.all_begun());
  EXPECT_EQ(granted(schedule), "begin 0");
  schedule.note_done(TileId{0}, Work::begin, 100, {});
  EXPECT_EQ(granted(schedule), "step 1");
}

TEST(Schedule, GivesUpTheLastOfTheTilesThatNobodyHasBegun) {
  Schedule schedule(options(1, 1000), {10, 10, 10, 10});
  EXPECT_EQ(granted(schedule), "begin 0");
  EXPECT_EQ(schedule.release(15), (std::vector{TileId{3}, TileId{2}}));
  schedule.note_done(TileId{0}, Work::begin, 100, {});
  EXPECT_EQ(granted(schedule), "begin 1");
  EXPECT_TRUE(schedule.release(15).empty()) << "it has begun";
  schedule.note_done(TileId{1}, Work::begin, 100, {});
  EXPECT_TRUE(schedule.idle());
  schedule.add(TileId{3}, 10);  // it has come back
  EXPECT_EQ(granted(schedule), "begin 3");
}

TEST(Schedule, WhatWasSettledIsSettledAgainAfterTilesHaveBegunAgain) {
  Schedule schedule(options(2, 1000), {10, 0});
  granted(schedule);
  schedule.note_done(TileId{0}, Work::begin, 100, {});
  schedule.enter(Mode::settling);
  EXPECT_EQ(granted(schedule), "settle 0");
  schedule.note_done(TileId{0}, Work::settle, 100, {});
  schedule.enter(Mode::exchanging);
  schedule.add(TileId{1}, 10);
  EXPECT_EQ(granted(schedule), "begin 1");
  schedule.note_done(TileId{1}, Work::begin, 100, {});
  EXPECT_TRUE(schedule.idle());
  schedule.enter(Mode::settling);
  EXPECT_EQ(granted(schedule), "settle 0, settle 1");
}

TEST(Schedule, TilesAsleepAreWokenToBeSettledWhereImagesAreNoUse) {
  auto how = options(1, 150);
  how.settle_asleep = true;
  Schedule schedule(how, {10, 10});
  EXPECT_EQ(granted(schedule), "begin 0");
  schedule.note_done(TileId{0}, Work::begin, 100, {});
  EXPECT_EQ(granted(schedule), "sleep 0");
  schedule.note_done(TileId{0}, Work::sleep, 0, {});
  EXPECT_EQ(granted(schedule), "begin 1");
  schedule.note_done(TileId{1}, Work::begin, 100, {});
  schedule.enter(Mode::settling);
  EXPECT_EQ(granted(schedule), "settle 1") << "first what is in memory";
  schedule.note_done(TileId{1}, Work::settle, 100, {});
  EXPECT_EQ(granted(schedule), "sleep 1");
  schedule.note_done(TileId{1}, Work::sleep, 0, {});
  EXPECT_EQ(granted(schedule), "settle 0");
  schedule.note_done(TileId{0}, Work::settle, 100, {});
  EXPECT_TRUE(schedule.idle());
}

// 20,000 tiles with mail: were each grant to look at all of them, this would take minutes.
// Tile 1 holds nothing after its beginning: there is nothing to put to sleep, and its first step builds it.
TEST(Schedule, ATileThatIsBuiltByMailNeedsRoomForThatAndNeverSleepsBefore) {
  ScheduleOptions built_by_mail = options(1, 250);
  built_by_mail.unbuilt_bytes = 50;
  Schedule schedule(built_by_mail, {10, 10, 10});
  EXPECT_EQ(granted(schedule), "begin 0");
  schedule.note_done(TileId{0}, Work::begin, 100, {});
  EXPECT_EQ(granted(schedule), "begin 1");
  schedule.note_done(TileId{1}, Work::begin, 5, {});
  EXPECT_EQ(granted(schedule), "begin 2");
  schedule.note_done(TileId{2}, Work::begin, 100, {});
  schedule.note_mail(TileId{1}, {1, 2, 2});
  EXPECT_EQ(granted(schedule), "sleep 0") << "207 held, and 100 to build";
  schedule.note_done(TileId{0}, Work::sleep, 0, {});
  EXPECT_EQ(granted(schedule), "step 1");
  EXPECT_EQ(schedule.memory(), 209u) << "100 of tile 2, 7 and 102 of tile 1";
  schedule.note_done(TileId{1}, Work::step, 100, {});
  schedule.enter(Mode::suspending);
  EXPECT_EQ(granted(schedule), "sleep 1");
  Schedule only(built_by_mail, {10});
  EXPECT_EQ(granted(only), "begin 0");
  only.note_done(TileId{0}, Work::begin, 5, {});
  only.enter(Mode::suspending);
  EXPECT_EQ(granted(only), "");
  EXPECT_TRUE(only.idle());
}

TEST(Schedule, ManyTilesCostLittle) {
  constexpr std::uint32_t tiles = 20'000;
  Schedule schedule(options(2, std::uint64_t{1} << 40), std::vector<std::uint64_t>(tiles, 1));
  const auto work_once = [&] {
    const auto permit = schedule.next();
    ASSERT_TRUE(permit);
    const bool begins = permit->work == Work::begin;
    schedule.note_done(permit->tile, permit->work, 10, begins ? Schedule::Waiting{1, 3, 120} : Schedule::Waiting{});
  };
  for (std::uint32_t t = 0; t < tiles; ++t) work_once();
  EXPECT_TRUE(schedule.all_begun());
  for (int round = 0; round < 20; ++round) {
    for (std::uint32_t t = 0; t < tiles; ++t) schedule.note_mail(TileId{t}, {2, t + 1u, 40});
    for (std::uint32_t t = 0; t < tiles; ++t) work_once();
  }
  EXPECT_TRUE(schedule.idle());
}

}  // namespace
}  // namespace tessera
