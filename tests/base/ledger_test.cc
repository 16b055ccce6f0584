#include "src/base/ledger.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

namespace tessera {
namespace {

Ledger::Bounds bounds_of(std::uint64_t disk) { return {.disk = {disk, "limits.disk, so much,"}}; }

TEST(LedgerTest, WhatIsDrawnNeverExceedsTheBoundHoweverManyDraw) {
  constexpr std::uint64_t most = 100'000;
  Ledger ledger(bounds_of(most));
  std::vector<std::uint64_t> drawn(4);
  {
    std::vector<std::jthread> threads;
    for (auto& mine : drawn)
      threads.emplace_back([&] {
        for (std::uint64_t step = 1; ledger.write(step % 7); ++step) mine += step % 7;
      });
  }
  std::uint64_t sum = 0;
  for (const auto mine : drawn) sum += mine;
  // Who has drawn while another one met the bound is refused as well.
  EXPECT_LE(sum, ledger.written());
  EXPECT_LE(ledger.written(), most);
  EXPECT_GT(ledger.written(), most - 7);
}

TEST(LedgerTest, TheBoundThatWasMetFirstIsNamedAndEndsAllThatDraws) {
  Ledger ledger({.disk = {10, "limits.disk, 10 B,"}, .memory = {5, "the question's memory"}});
  ASSERT_TRUE(ledger.write(10));
  EXPECT_FALSE(ledger.token().stop_requested());
  const auto refused = ledger.write(1);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Errc::memory);
  EXPECT_EQ(refused.error().where, "the job needs more disk than limits.disk, 10 B, allows");
  EXPECT_TRUE(ledger.token().stop_requested());
  EXPECT_EQ(ledger.hold(100).error().where, refused.error().where);
  EXPECT_EQ(ledger.go_on().error().where, refused.error().where);
  ledger.stop(error(Errc::memory, "too late"));
  EXPECT_EQ(ledger.reason()->where, refused.error().where);
}

TEST(LedgerTest, WorkThatNobodyWantsHasNoReasonAndWritesNothing) {
  Ledger ledger;
  ASSERT_TRUE(ledger.write(1 << 20));
  ledger.stop();
  EXPECT_EQ(ledger.write(1).error().code, Errc::interrupted);
  EXPECT_FALSE(ledger.reason());
  ledger.stop(error(Errc::memory, "too late"));
  EXPECT_FALSE(ledger.reason());
}

TEST(LedgerTest, MemoryComesBackAndFilesDoNot) {
  Ledger ledger({.memory = {10, "m"}, .files = {2, "f"}});
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(ledger.hold(10));
    ledger.give_back(10);
  }
  ASSERT_TRUE(ledger.name_files(2));
  EXPECT_EQ(ledger.name_files(1).error().where, "the job needs more files than f allows");
}

TEST(LedgerTest, TheReserveOfTheDiskStaysFree) {
  std::uint64_t free = std::uint64_t{100} << 20;
  Ledger ledger({.reserve_bytes = std::uint64_t{60} << 20, .free_bytes = [&] { return free; }});
  ASSERT_TRUE(ledger.write(1 << 20));
  free = std::uint64_t{70} << 20;
  ASSERT_TRUE(ledger.write(8 << 20));
  free = std::uint64_t{61} << 20;
  const auto refused = ledger.write(16 << 20);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Errc::io);
  EXPECT_NE(refused.error().where.find("limits.reserve"), std::string::npos);
}

TEST(LedgerTest, AThreadDrawsFromTheLedgerThatItUsesAndFromNoneElse) {
  Ledger outer(bounds_of(100)), inner(bounds_of(100));
  EXPECT_TRUE(Ledger::draw_write(1'000'000));
  {
    const Ledger::Use use(&outer);
    EXPECT_TRUE(Ledger::draw_write(1));
    {
      const Ledger::Use other(&inner);
      EXPECT_TRUE(Ledger::draw_write(2));
      const Ledger::Use none(nullptr);
      EXPECT_TRUE(Ledger::draw_write(1'000'000));
    }
    EXPECT_TRUE(Ledger::draw_write(3));
    std::jthread([&] { EXPECT_EQ(Ledger::of_thread(), nullptr); });
  }
  EXPECT_EQ(outer.written(), 4U);
  EXPECT_EQ(inner.written(), 2U);
}

TEST(LedgerTest, WhatOthersHaveWrittenCountsOnce) {
  Ledger ledger(bounds_of(100));
  ASSERT_TRUE(ledger.written_by_others(60));
  ASSERT_TRUE(ledger.written_by_others(40));
  EXPECT_EQ(ledger.written(), 60U);
  EXPECT_FALSE(ledger.written_by_others(101));
}

}  // namespace
}  // namespace tessera
