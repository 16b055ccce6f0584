// What waits for another node: in order, within the window, and beyond memory on scratch.
#include "src/exchange/outbox.h"

#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "src/base/files/temporary.h"

namespace tessera {
namespace {

Update update(std::uint32_t number, std::size_t bytes = 400) {
  Update out;
  out.from = {TileId{number}, 1};
  out.to = {TileId{number + 1}, 2};
  out.epoch = {Term{3}, 4};
  out.hops = number;
  for (std::size_t i = 0; i < bytes; ++i) out.message.push_back(std::byte(number * 7 + i));
  return out;
}

std::vector<std::uint32_t> numbers(const std::vector<Update>& updates) {
  std::vector<std::uint32_t> out;
  for (const Update& u : updates) out.push_back(u.from.tile.value);
  return out;
}

class GateTest : public ::testing::Test {
 protected:
  const std::uint64_t one = Outbox::bytes_of(update(0));
  TemporaryFolder folder_ = TemporaryFolder::make().value();
  const std::filesystem::path scratch_ = folder_.path() / "gate";
};

TEST_F(GateTest, SendsParcelsInOrderWhileTheWindowHasRoom) {
  Outbox outbox({.window_bytes = 5 * one, .packet_bytes = 2 * one, .memory_bytes = 100 * one}, scratch_);
  EXPECT_TRUE(outbox.next().value().empty());
  for (std::uint32_t n = 0; n < 7; ++n) ASSERT_TRUE(outbox.add(update(n)));
  EXPECT_EQ(numbers(outbox.next().value()), (std::vector<std::uint32_t>{0, 1}));
  EXPECT_EQ(numbers(outbox.next().value()), (std::vector<std::uint32_t>{2, 3}));
  EXPECT_TRUE(outbox.next().value().empty());  // a third parcel would be beyond the window
  outbox.taken(one);                           // four of five are on their way
  EXPECT_EQ(numbers(outbox.next().value()), (std::vector<std::uint32_t>{4, 5}));
  EXPECT_TRUE(outbox.next().value().empty());
  outbox.taken(5 * one);
  EXPECT_EQ(numbers(outbox.next().value()), (std::vector<std::uint32_t>{6}));
  EXPECT_EQ(outbox.waiting_bytes(), 0U);
  EXPECT_EQ(outbox.counts().packets, 4U);
  EXPECT_EQ(outbox.counts().bytes, 7 * one);
  EXPECT_EQ(outbox.counts().waits, 2U);
}

// Else it would never go.
TEST_F(GateTest, SendsWhatIsLargerThanTheWindowAlone) {
  Outbox outbox({.window_bytes = one, .packet_bytes = one, .memory_bytes = 100 * one}, scratch_);
  ASSERT_TRUE(outbox.add(update(0, 4000)));
  ASSERT_TRUE(outbox.add(update(1)));
  EXPECT_EQ(numbers(outbox.next().value()), std::vector<std::uint32_t>{0});
  EXPECT_TRUE(outbox.next().value().empty());
  outbox.taken(Outbox::bytes_of(update(0, 4000)));
  EXPECT_EQ(numbers(outbox.next().value()), std::vector<std::uint32_t>{1});
}

TEST_F(GateTest, PutsWhatIsTooMuchOnScratchAndTakesItBackInOrder) {
  Outbox outbox({.window_bytes = 1000 * one, .packet_bytes = 2 * one, .memory_bytes = 3 * one}, scratch_);
  for (std::uint32_t n = 0; n < 50; ++n) ASSERT_TRUE(outbox.add(update(n)));
  EXPECT_TRUE(std::filesystem::exists(scratch_));
  EXPECT_EQ(outbox.waiting_bytes(), 50 * one);
  std::uint32_t expected = 0;
  while (true) {
    const auto packet = outbox.next().value();
    if (packet.empty()) break;
    for (const Update& got : packet) {
      const Update wanted = update(expected++);
      EXPECT_EQ(got.from, wanted.from);
      EXPECT_EQ(got.to, wanted.to);
      EXPECT_EQ(got.epoch, wanted.epoch);
      EXPECT_EQ(got.hops, wanted.hops);
      EXPECT_EQ(got.message, wanted.message);
    }
  }
  EXPECT_EQ(expected, 50U);
  EXPECT_FALSE(std::filesystem::exists(scratch_));
}

TEST_F(GateTest, WithoutScratchHoldsEverything) {
  Outbox outbox({.window_bytes = 1000 * one, .packet_bytes = 2 * one, .memory_bytes = one}, {});
  for (std::uint32_t n = 0; n < 50; ++n) ASSERT_TRUE(outbox.add(update(n)));
  EXPECT_EQ(numbers(outbox.next().value()), (std::vector<std::uint32_t>{0, 1}));
}

TEST_F(GateTest, FindsDamageOnScratch) {
  Outbox outbox({.window_bytes = 1000 * one, .packet_bytes = 2 * one, .memory_bytes = one}, scratch_);
  for (std::uint32_t n = 0; n < 4; ++n) ASSERT_TRUE(outbox.add(update(n)));
  std::fstream file(scratch_, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(100);
  file.put('x');
  file.close();
  const auto packet = outbox.next();
  ASSERT_FALSE(packet);
  EXPECT_EQ(packet.error().code, Errc::corrupt);
  EXPECT_NE(packet.error().where.find(scratch_.string()), std::string::npos);
}

TEST_F(GateTest, ForgetsWhatWaitsForWhoeverIsLost) {
  Outbox outbox({.window_bytes = 2 * one, .packet_bytes = 2 * one, .memory_bytes = one}, scratch_);
  for (std::uint32_t n = 0; n < 9; ++n) ASSERT_TRUE(outbox.add(update(n)));
  ASSERT_FALSE(outbox.next().value().empty());
  outbox.clear();
  EXPECT_EQ(outbox.waiting_bytes(), 0U);
  EXPECT_FALSE(std::filesystem::exists(scratch_));
  EXPECT_TRUE(outbox.next().value().empty());
}

}  // namespace
}  // namespace tessera
