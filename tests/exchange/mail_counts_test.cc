#include "src/exchange/mail_counts.h"

#include <gtest/gtest.h>

#include <thread>

namespace tessera {
namespace {

TEST(MailCounts, AddUpWhatEachPartTellsAnother) {
  MailCounts counts(map_regions_of({}, 4, MailCounts::regions_max));
  counts.add(TileId{0}, TileId{1}, 5);
  counts.add(TileId{0}, TileId{1}, 6);
  counts.add(TileId{3}, TileId{2}, 20);
  counts.add(TileId{1}, TileId{0}, 1);
  counts.add(TileId{2}, TileId{2}, 9);    // to itself
  counts.add(TileId{2}, TileId{700}, 9);  // of another run
  EXPECT_EQ(counts.take(2), (std::vector<MailArc>{{-4, -3, 20}, {-1, -2, 11}}));
  EXPECT_TRUE(counts.take(2).empty());  // the lightest is forgotten, too
  EXPECT_TRUE(MailCounts(map_regions_of({}, 0, 4)).take(1).empty());
}

TEST(MailCounts, LoseNothingOfWhatManyThreadsTell) {
  MailCounts counts(map_regions_of({}, 1000, 2));
  std::uint64_t sum = 0;
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < 4; ++i) {
      threads.emplace_back([&] {
        for (int n = 0; n < 10'000; ++n) counts.add(TileId{1}, TileId{999}, 3);
      });
    }
    for (int n = 0; n < 100; ++n) {
      for (const MailArc& arc : counts.take(8)) sum += arc.bytes;
    }
  }
  for (const MailArc& arc : counts.take(8)) sum += arc.bytes;
  EXPECT_EQ(sum, 120'000U);
}

}  // namespace
}  // namespace tessera
