#include "src/exchange/assignment.h"

#include <gtest/gtest.h>

#include <numeric>
#include <vector>

namespace tessera {
namespace {

std::vector<TileId> tiles(std::initializer_list<std::uint32_t> numbers) {
  std::vector<TileId> list;
  for (const std::uint32_t n : numbers) list.push_back(TileId{n});
  return list;
}

std::vector<NodeId> nodes(std::initializer_list<std::uint32_t> numbers) {
  std::vector<NodeId> list;
  for (const std::uint32_t n : numbers) list.push_back(NodeId{n});
  return list;
}

TEST(ShareOut, CutsTheOrderIntoRunsByPointsAndThreads) {
  const std::vector<std::uint64_t> even(6, 10);
  const std::vector<Host> two{{NodeId{0}, 1}, {NodeId{1}, 1}};
  EXPECT_EQ(share_out(tiles({3, 4, 5, 0, 1, 2}), even, two), nodes({0, 0, 0, 1, 1, 1})) << "in the order given";
  const std::vector<Host> unlike{{NodeId{7}, 1}, {NodeId{2}, 2}};
  EXPECT_EQ(share_out(tiles({0, 1, 2, 3, 4, 5}), even, unlike), nodes({7, 7, 2, 2, 2, 2}));
  const std::vector<std::uint64_t> heavy{1, 1, 98, 1, 1};
  EXPECT_EQ(share_out(tiles({0, 1, 2, 3, 4}), heavy, two), nodes({0, 0, 0, 1, 1}));
}

TEST(ShareOut, GivesNoTileToAHostWithoutRoomForIt) {
  const std::vector<std::uint64_t> points{40, 50, 40, 50};
  const std::vector<Host> small{{NodeId{0}, 1}, {NodeId{1}, 1, 20}, {NodeId{2}, 2}};
  EXPECT_EQ(share_out(tiles({0, 1, 2, 3}), points, small), nodes({0, 0, 2, 2}))
      << "the second would be the middle one's";
  EXPECT_TRUE(any_has_room(small, 50));
  EXPECT_FALSE(any_has_room(std::span(small).subspan(1, 1), 21));
}

TEST(ShareOut, EveryTileHasAHostWhateverTheCounts) {
  EXPECT_TRUE(share_out({}, {}, std::vector<Host>{{NodeId{0}, 1}}).empty());
  const std::vector<std::uint64_t> points{5, 0, 0};
  const std::vector<Host> many{{NodeId{0}, 1}, {NodeId{1}, 1}, {NodeId{2}, 1}, {NodeId{3}, 1}};
  EXPECT_EQ(share_out(tiles({0, 1, 2}), points, many).size(), 3u);
  EXPECT_EQ(share_out(tiles({1, 2}), points, many), nodes({0, 0})) << "tiles without points";
}

std::vector<Incarnation> lives(const std::vector<std::uint32_t>& numbers) {
  std::vector<Incarnation> lives;
  for (const std::uint32_t number : numbers) lives.push_back({{}, number});
  return lives;
}

TEST(PlaceAgain, TilesBeginAgainAsOtherIncarnations) {
  const RoutingTable table{{{}, 4}, 0, nodes({0, 1, 1, 2}), lives({0, 3, 0, 7})};
  const std::vector<std::uint64_t> points{1, 1, 1, 1};
  const auto changes = place_again(table, tiles({1, 2}), points, std::vector<Host>{{NodeId{0}, 1}, {NodeId{2}, 1}});
  EXPECT_EQ(changes, (std::vector<Placement>{{TileId{1}, NodeId{0}, {{}, 4}}, {TileId{2}, NodeId{2}, {{}, 1}}}));
  const RoutingTable next = next_table(table, {{}, 5}, changes);
  EXPECT_EQ(next, (RoutingTable{{{}, 5}, 0, nodes({0, 0, 2, 2}), lives({0, 4, 1, 7})}));
  EXPECT_TRUE(next.alive({TileId{1}, {{}, 4}}));
  EXPECT_FALSE(next.alive({TileId{1}, {{}, 3}}));
}

}  // namespace
}  // namespace tessera
