// How a resumed run knows which tiles are stored.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "src/base/files/names.h"
#include "src/base/files/temporary.h"
#include "src/base/files/whole_file.h"
#include "src/result/store/tile_store.h"
#include "tests/store/sample_result.h"

namespace tessera::test {
namespace {

namespace fs = std::filesystem;

std::vector<std::byte> bytes_of(const fs::path& path) { return read_whole(path).value(); }

TEST(StoredTiles, AreSeenByARunThatIsResumed) {
  const TemporaryFolder folder;
  const auto meshes = sample_tiles(sample_points(Shape::uniform, 3, 300), 3, 3);
  EXPECT_TRUE(stored_tiles(folder.path()).value().empty());
  const auto entry = write_tile(folder.path(), TileId{1}, meshes[1], {}, {});
  ASSERT_TRUE(entry);
  EXPECT_EQ(stored_tiles(folder.path()).value(), std::vector{entry.value()});
  store_sample(folder.path(), meshes);
  EXPECT_TRUE(stored_tiles(folder.path()).value().empty()) << "finish_store removes the side files";
}

// Of its own vertices, but for what is no number; a run that is resumed knows it, too.
TEST(StoredTiles, TellTheHeightsOfAPlane) {
  const TemporaryFolder folder;
  const auto meshes = sample_tiles(sample_points(Shape::uniform, 2, 300), 2, 3);
  StoreOptions options;
  options.schema = {{"a", AttributeType::u8}, {"z", AttributeType::f64}};
  std::vector<TileEntry> entries;
  for (std::uint32_t t = 0; t < 3; ++t) {
    std::vector<std::byte> rows;
    HeightRange expected{1e9, -1e9};
    for (std::size_t i = 0; i < meshes[t].points.size(); ++i) {
      const bool own = meshes[t].point_ghost[i] == 0;
      double z = own ? 0.1 * static_cast<double>(meshes[t].ids[i].value) - 7 : 1e6;
      if (own && i > 0) expected = {std::min(expected.lo, z), std::max(expected.hi, z)};
      if (i == 0) z = std::numeric_limits<double>::quiet_NaN();
      rows.push_back(std::byte{1});
      const auto* bytes = reinterpret_cast<const std::byte*>(&z);
      rows.insert(rows.end(), bytes, bytes + sizeof z);
    }
    const auto entry = write_tile(folder.path(), TileId{t}, meshes[t], rows, options);
    ASSERT_TRUE(entry) << entry.error().where;
    EXPECT_EQ(entry.value().heights, expected);
    entries.push_back(entry.value());
  }
  EXPECT_EQ(stored_tiles(folder.path()).value(), entries);
}

TEST(StoredTiles, AreToldByEachNodeForItself) {
  const TemporaryFolder folder;
  const auto meshes = sample_tiles(sample_points(Shape::uniform, 3, 300), 3, 3);
  StoreOptions options;
  std::vector<TileEntry> entries;
  for (std::uint32_t t = 0; t < 3; ++t) {
    options.node = NodeId{t};
    const auto entry = write_tile(folder.path(), TileId{t}, meshes[t], {}, options);
    ASSERT_TRUE(entry);
    entries.push_back(entry.value());
  }
  EXPECT_EQ(stored_tiles(folder.path()).value(), entries);
  // A tile that was stored before, by whichever node, and has been stored again.
  ASSERT_TRUE(write_tile(folder.path(), TileId{0}, meshes[1], {}, options));
  options.node = NodeId{0};
  ASSERT_TRUE(write_tile(folder.path(), TileId{0}, meshes[0], {}, options));
  EXPECT_EQ(stored_tiles(folder.path()).value(), entries);
  // Older software wrote a file for each tile.
  fs::rename(done_file(folder.path(), NodeId{1}), tiles_folder(folder.path()) / "000001.done");
  EXPECT_EQ(stored_tiles(folder.path()).value(), entries);
}

// Bits of the tile file and of its side file: whatever is damaged, the tile is made again.
TEST(StoredTiles, AreNotThoseThatAreDamaged) {
  const TemporaryFolder folder;
  const auto meshes = sample_tiles(sample_points(Shape::uniform, 3, 300), 3, 2);
  const auto kept = write_tile(folder.path(), TileId{0}, meshes[0], {}, {});
  const auto entry = write_tile(folder.path(), TileId{1}, meshes[1], {}, {});
  ASSERT_TRUE(kept && entry);
  const std::vector both{kept.value(), entry.value()};
  ASSERT_EQ(stored_tiles(folder.path()).value(), both);
  const auto damage = [&](const fs::path& path, std::size_t from, const std::vector<TileEntry>& left) {
    const auto whole = bytes_of(path);
    for (std::size_t bit = 8 * from; bit < 8 * whole.size(); bit += 8 * whole.size() / 400 + 1) {
      auto damaged = whole;
      damaged[bit / 8] ^= std::byte{1} << (bit % 8);
      ASSERT_TRUE(write_whole(path, damaged));
      const auto stored = stored_tiles(folder.path()).value();
      EXPECT_TRUE(stored == left || stored == both) << path << ", bit " << bit;
      // What is between lines says nothing.
      EXPECT_TRUE(stored == left || whole[bit / 8] == std::byte{'\n'}) << path << ", bit " << bit;
    }
    for (const std::size_t size : {from, (from + whole.size()) / 2, whole.size() - 2}) {
      ASSERT_TRUE(write_whole(path, std::span(whole).first(size)));
      EXPECT_EQ(stored_tiles(folder.path()).value(), left) << path << " cut to " << size;
    }
    ASSERT_TRUE(write_whole(path, whole));
    EXPECT_EQ(stored_tiles(folder.path()).value(), both);
  };
  damage(tile_file(folder.path(), TileId{1}), 0, {kept.value()});
  const auto bytes = bytes_of(done_file(folder.path(), NodeId{}));
  const std::string lines(as_text(bytes));
  damage(done_file(folder.path(), NodeId{}), lines.find('\n', 1) + 1, {kept.value()});
  // A process that ends in the middle of a line spoils no other.
  const std::string begun = lines + "\n1 17 12";
  ASSERT_TRUE(write_whole(done_file(folder.path(), NodeId{}), std::as_bytes(std::span(begun))));
  EXPECT_EQ(stored_tiles(folder.path()).value(), both);
  const auto again = write_tile(folder.path(), TileId{1}, meshes[0], {}, {});
  ASSERT_TRUE(again);
  EXPECT_EQ(stored_tiles(folder.path()).value(), (std::vector{kept.value(), again.value()}))
      << "the line of the file that is there counts";
  fs::remove(tile_file(folder.path(), TileId{1}));
  EXPECT_EQ(stored_tiles(folder.path()).value(), std::vector{kept.value()});
}

}  // namespace
}  // namespace tessera::test
