#include "src/exchange/inbox.h"

#include <gtest/gtest.h>

#include <map>
#include <utility>

namespace tessera {
namespace {

// Keeps mail alone.
class Scratch final : public TileStorage {
 public:
  Status write(TileId, ScratchKind, std::span<const std::byte>) override { return success(); }
  Status append(TileId, ScratchKind what, std::span<const std::byte> bytes) override {
    EXPECT_EQ(what, ScratchKind::mail);
    pieces.emplace_back(bytes.begin(), bytes.end());
    return success();
  }
  Result<Pieces> read(TileId, ScratchKind) override { return pieces; }
  Result<bool> has(TileId, ScratchKind) override { return !pieces.empty(); }
  Status remove(TileId, ScratchKind) override {
    pieces.clear();
    return success();
  }
  Status clear(ScratchKind) override { return success(); }
  Pieces pieces;
};

Update update(std::uint32_t from, std::size_t bytes) {
  return {{TileId{from}, {Term{2}, 3}},
          {TileId{9}, {{}, 1}},
          {Term{from}, from + 2},
          from + 7,
          BigVector<std::byte>(bytes, std::byte(from + 1))};
}

TEST(Inbox, ComesBackAsItWasPutOnScratchOrNot) {
  for (const std::uint64_t bytes_max : {0u, 4u, 100u}) {
    Scratch scratch;
    Inbox inbox(TileId{9}, bytes_max);
    for (const std::uint32_t from : {0u, 1u, 2u, 3u}) ASSERT_TRUE(inbox.add(update(from, from), scratch));
    EXPECT_EQ(inbox.updates(), 4u);
    EXPECT_EQ(inbox.bytes(), 6u);
    const auto taken = inbox.take(scratch);
    ASSERT_TRUE(taken);
    ASSERT_EQ(taken.value().size(), 4u);
    for (std::uint32_t from = 0; from < 4; ++from) {
      const Update& b = taken.value()[from];
      EXPECT_EQ(b.from, update(from, from).from);
      EXPECT_EQ(b.to, update(from, from).to);
      EXPECT_EQ(b.epoch, (Epoch{Term{from}, from + 2}));
      EXPECT_EQ(b.hops, from + 7);
      EXPECT_EQ(b.message, update(from, from).message);
    }
    EXPECT_EQ(inbox.updates(), 0u);
    EXPECT_TRUE(scratch.pieces.empty());
    EXPECT_TRUE(inbox.take(scratch).value().empty());
  }
}

TEST(Inbox, HoldsNoMoreBytesInMemoryThanItMay) {
  Scratch scratch;
  Inbox inbox(TileId{9}, 100);
  for (int i = 0; i < 1000; ++i) {
    ASSERT_TRUE(inbox.add(update(1, 30), scratch));
    EXPECT_LE(inbox.memory(), 130 + 16 * sizeof(Update));
  }
  EXPECT_EQ(inbox.bytes(), 30'000u);
  EXPECT_EQ(inbox.take(scratch).value().size(), 1000u);
}

TEST(Inbox, WhatIsMissingOnScratchIsNoticed) {
  Scratch scratch;
  Inbox inbox(TileId{9}, 0);
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(inbox.add(update(1, 5), scratch));
  scratch.pieces.pop_back();
  const auto taken = inbox.take(scratch);
  ASSERT_FALSE(taken);
  EXPECT_EQ(taken.error().code, Errc::corrupt);
}

}  // namespace
}  // namespace tessera
