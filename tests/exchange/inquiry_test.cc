// What the answers of nodes, and losses of nodes among them, mean for a coordinator that takes over.
#include "src/exchange/inquiry.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace tessera {
namespace {

RoutingTable table_of(std::uint32_t epoch, const std::vector<std::uint32_t>& nodes) {
  RoutingTable table;
  table.epoch = {{}, epoch};
  for (const std::uint32_t node : nodes) table.nodes.push_back(NodeId{node});
  table.incarnations.resize(nodes.size());
  return table;
}

Inquiry::Answer with_share(std::uint32_t self, RoutingTable table) {
  Inquiry::Answer answer;
  answer.has_share = true;
  answer.self = NodeId{self};
  answer.begun = true;
  answer.table = std::move(table);
  return answer;
}

TEST(Inquiry, WaitsUntilAllHaveAnswered) {
  Inquiry inquiry;
  EXPECT_TRUE(inquiry.nobody());
  const auto a = inquiry.ask(), b = inquiry.ask();
  EXPECT_TRUE(inquiry.waits());
  EXPECT_FALSE(inquiry.nobody());
  inquiry.take(b, {});
  EXPECT_TRUE(inquiry.is_open(a) && !inquiry.is_open(b));
  EXPECT_TRUE(inquiry.is_answered(b) && !inquiry.is_answered(a));
  EXPECT_TRUE(inquiry.waits());
  inquiry.take(a, {});
  EXPECT_FALSE(inquiry.waits());
  ASSERT_EQ(inquiry.answers().size(), 2u);
  EXPECT_EQ(inquiry.answers()[0].question, b) << "answers stand in the order in which they came";
}

TEST(Inquiry, WithoutAnyShareHasNoTable) {
  Inquiry inquiry;
  inquiry.take(inquiry.ask(), {});
  EXPECT_FALSE(inquiry.newest(table_of(3, {0, 1})));
  EXPECT_EQ(inquiry.numbers(std::nullopt), 0u);
}

TEST(Inquiry, FindsTheNewestTableThatAnyShareGoesBy) {
  Inquiry inquiry;
  inquiry.take(inquiry.ask(), with_share(0, table_of(4, {0, 5})));
  inquiry.take(inquiry.ask(), with_share(2, table_of(2, {0, 2})));
  inquiry.take(inquiry.ask(), {});
  const auto newest = inquiry.newest(table_of(0, {0, 0}));
  ASSERT_TRUE(newest);
  EXPECT_EQ(*newest, table_of(4, {0, 5}));
  EXPECT_EQ(inquiry.numbers(newest), 6u) << "node 5 has a tile, and is not found";
  EXPECT_EQ(inquiry.newest(table_of(9, {1, 1})), table_of(9, {1, 1}));
  EXPECT_EQ(inquiry.newest(table_of(4, {1, 1})), table_of(4, {0, 5})) << "of equal epochs that of the share counts";
}

TEST(Inquiry, ForgetsALostNodeAndKeepsTheNumberOfItsShare) {
  Inquiry inquiry;
  const auto a = inquiry.ask(), b = inquiry.ask(), c = inquiry.ask();
  inquiry.take(a, with_share(7, table_of(1, {7})));
  inquiry.take(c, {});
  EXPECT_EQ(inquiry.lose(b), Inquiry::Lost::question);
  EXPECT_FALSE(inquiry.waits());
  EXPECT_EQ(inquiry.lose(b), Inquiry::Lost::nothing);
  EXPECT_EQ(inquiry.lose(a), Inquiry::Lost::answer);
  EXPECT_FALSE(inquiry.is_answered(a));
  EXPECT_FALSE(inquiry.newest(table_of(0, {0})));
  EXPECT_EQ(inquiry.numbers(std::nullopt), 8u) << "the share may still speak";
  EXPECT_EQ(inquiry.lose(c), Inquiry::Lost::answer);
  EXPECT_TRUE(inquiry.nobody());
  EXPECT_EQ(inquiry.numbers(std::nullopt), 8u);
}

TEST(Inquiry, ANodeWhoseShareHasEndedSinceHasAnsweredWithoutOne) {
  Inquiry inquiry;
  inquiry.take(inquiry.ask(), with_share(0, table_of(1, {0, 1})));
  inquiry.take(inquiry.ask(), with_share(1, table_of(1, {0, 1})));
  inquiry.end_share(NodeId{1});
  EXPECT_TRUE(inquiry.answers()[0].answer.has_share);
  EXPECT_FALSE(inquiry.answers()[1].answer.has_share);
  inquiry.end_share(NodeId{0});
  EXPECT_FALSE(inquiry.newest(table_of(0, {})));
}

TEST(Inquiry, CountsATileAsGivenUpByTheNodeThatHasIt) {
  Inquiry inquiry;
  const RoutingTable table = table_of(1, {0, 1, 1});
  auto first = with_share(0, table), second = with_share(1, table);
  first.released = {TileId{1}};  // it went to node 1 since
  second.released = {TileId{2}};
  inquiry.take(inquiry.ask(), std::move(first));
  inquiry.take(inquiry.ask(), std::move(second));
  EXPECT_EQ(inquiry.given_up(table, 3), (std::vector<bool>{false, false, true}));
}

}  // namespace
}  // namespace tessera
