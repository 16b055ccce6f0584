#include "src/exchange/settled_files.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <set>
#include <thread>

#include "src/base/files/names.h"
#include "src/base/files/temporary.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

class Settled : public ::testing::Test {
 protected:
  static BigVector<std::byte> bytes_of(std::uint32_t tile) {
    return BigVector<std::byte>(tile % 5 * 7, std::byte(tile));
  }
  SettledFiles files(std::uint32_t node = 0) const { return {folder_.path(), seal, NodeId{node}}; }
  void append(std::uint32_t node, std::uint32_t begin, std::uint32_t end) const {
    SettledFiles of_node(folder_.path(), seal, NodeId{node});
    for (std::uint32_t t = begin; t < end; ++t) EXPECT_TRUE(of_node.append(TileId{t}, bytes_of(t)));
  }
  // The tiles that are said to be there; each is there as it was written, or found to be damaged.
  std::set<std::uint32_t> there(std::uint32_t tiles) const {
    SettledFiles all(folder_.path(), seal, NodeId{0});
    std::set<std::uint32_t> found;
    for (std::uint32_t t = 0; t < tiles; ++t) {
      const auto has = all.has(TileId{t});
      const auto read = all.read(TileId{t});
      if (read) {
        EXPECT_EQ(has.value(), read.value().has_value());
        if (!read.value()) continue;
        EXPECT_EQ(*read.value(), bytes_of(t));
        found.insert(t);
      } else {
        EXPECT_EQ(read.error().code, Errc::corrupt);
      }
    }
    return found;
  }

  static constexpr std::uint64_t seal = 4711;
  TemporaryFolder folder_ = TemporaryFolder::make().value();
};

TEST_F(Settled, OfAllNodesAreFoundByEach) {
  EXPECT_TRUE(there(3).empty());
  append(0, 0, 10);
  append(7, 10, 15);
  EXPECT_EQ(there(20).size(), 15u);
  SettledFiles again(folder_.path(), seal, NodeId{7});
  EXPECT_FALSE(again.has(TileId{15}).value());
  EXPECT_TRUE(again.append(TileId{15}, bytes_of(15)));
  EXPECT_EQ(again.read(TileId{15}).value(), bytes_of(15));
  EXPECT_TRUE(again.clear());
  EXPECT_FALSE(again.has(TileId{15}).value());
  EXPECT_TRUE(there(20).empty());
}

TEST_F(Settled, OfSeveralThreadsDoNotMix) {
  SettledFiles shared(folder_.path(), seal, NodeId{0});
  {
    std::vector<std::jthread> threads;
    for (std::uint32_t k = 0; k < 4; ++k)
      threads.emplace_back([&, k] {
        for (std::uint32_t t = k; t < 200; t += 4) EXPECT_TRUE(shared.append(TileId{t}, bytes_of(t)));
      });
  }
  EXPECT_EQ(there(200).size(), 200u);
}

TEST_F(Settled, DamageOfATileIsItsOwnOrHidesThoseBehindIt) {
  append(0, 1, 5);
  const auto file = settled_file(folder_.path(), NodeId{0});
  const auto size = fs::file_size(file);
  const auto flip = [&](std::size_t bit) {  // in place: to make the file again, and again, takes long
    std::fstream in_place(file, std::ios::in | std::ios::out | std::ios::binary);
    in_place.seekg(static_cast<std::streamoff>(bit / 8));
    const int byte = in_place.get();
    in_place.seekp(static_cast<std::streamoff>(bit / 8));
    in_place.put(static_cast<char>(byte ^ 1 << bit % 8));
  };
  for (std::size_t bit = 0; bit < 8 * size; ++bit) {
    flip(bit);
    EXPECT_LT(there(6).size(), 4u) << "bit " << bit;
    flip(bit);
  }
  ASSERT_EQ(there(6).size(), 4u);
  for (auto left = size; left-- > 0;) {
    fs::resize_file(file, left);
    const auto tiles = there(6);
    EXPECT_LT(tiles.size(), 4u) << "cut to " << left;
    EXPECT_TRUE(tiles.empty() || *tiles.rbegin() == tiles.size()) << "cut to " << left << ": the first ones are left";
  }
}

TEST_F(Settled, OfAnotherRunAreDamage) {
  append(0, 1, 3);
  SettledFiles other(folder_.path(), seal + 1, NodeId{0});
  for (std::uint32_t t = 1; t < 3; ++t) EXPECT_EQ(other.read(TileId{t}).error().code, Errc::corrupt);
}

// Older software had a file for each tile: not what is read here, so such a run is not taken for settled.
TEST_F(Settled, OfOlderSoftwareAreNotTakenForOurs) {
  append(0, 2, 3);
  fs::rename(settled_file(folder_.path(), NodeId{0}), scratch_file(folder_.path(), ScratchKind::settled, TileId{2}));
  EXPECT_TRUE(there(6).empty());
}

}  // namespace
}  // namespace tessera
