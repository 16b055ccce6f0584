#include "src/exchange/node_room.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace tessera {
namespace {

// Three tiles, of weights 1, 10 and 4; a node of so many bytes has room for a tile of that weight.
Placements three_tiles() { return {{{1, 10, 4}, {TileId{0}, TileId{1}, TileId{2}}, {}}, {}}; }
NodeRoom by_bytes() {
  return {[](std::uint32_t, std::uint64_t bytes) { return bytes; },
          [](std::uint64_t weight) { return "a tile of weight " + std::to_string(weight); }};
}

TEST(NodeRoom, IsForTilesUpToAWeight) {
  const NodeRoom room = by_bytes();
  const Placements tiles = three_tiles();
  const Host small = room.host(NodeId{3}, 2, 4);
  EXPECT_EQ(small.node, NodeId{3});
  EXPECT_EQ(small.threads, 2u);
  EXPECT_TRUE(NodeRoom::has_any(small, tiles));
  EXPECT_FALSE(NodeRoom::has_any(room.host(NodeId{0}, 1, 0), tiles));
  EXPECT_EQ(NodeRoom::without(std::vector<Host>{small}, tiles), std::vector<TileId>{TileId{1}});
  EXPECT_TRUE(NodeRoom::without(std::vector<Host>{small, room.host(NodeId{1}, 1, 10)}, tiles).empty());
}

TEST(NodeRoom, IsThereForAnyTileWhenNothingIsKnown) {
  const NodeRoom room({}, {});
  const Placements tiles = three_tiles();
  EXPECT_TRUE(NodeRoom::without(std::vector<Host>{room.host(NodeId{0}, 1, 0)}, tiles).empty());
  const std::vector<NodeRoom::Named> one{{"a", std::uint64_t{3} << 20}};
  EXPECT_NE(room.why_none(tiles.order(), tiles, one).find("one of the tiles"), std::string::npos);
}

TEST(NodeRoom, NamesTheLargestTileAndTheNodeThatGivesMost) {
  const Placements tiles = three_tiles();
  const std::vector<NodeRoom::Named> nodes{{"a", std::uint64_t{2} << 20}, {"b", std::uint64_t{5} << 20}, {"c", 7}};
  const std::string why = by_bytes().why_none(tiles.order(), tiles, nodes);
  EXPECT_NE(why.find("a tile of weight 10"), std::string::npos) << why;
  EXPECT_NE(why.find("node b"), std::string::npos) << why;
  EXPECT_NE(why.find("5 MiB"), std::string::npos) << why;
}

}  // namespace
}  // namespace tessera
