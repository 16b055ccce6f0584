// Files of points that something happened to, or that somebody made: corrupt, and the sentence names the place.
#include <gtest/gtest.h>
#include <zstd.h>

#include <functional>
#include <limits>
#include <string>

#include "src/base/files/checksum.h"
#include "src/base/files/whole_file.h"
#include "src/result/store/points_file.h"
#include "tests/store/points_testing.h"
#include "tests/store/sample_result.h"

namespace tessera::test {
namespace {

using Bytes = std::vector<std::byte>;

template <class List>
Bytes bytes_of(const List& values) {
  const auto bytes = std::as_bytes(std::span(values));
  return {bytes.begin(), bytes.end()};
}

// A file whose sums are right whatever is changed in it.
struct Forged {
  store::PointsHead head;
  std::vector<Bytes> blocks;

  explicit Forged(std::span<const std::byte> file)
      : head(std::get<store::PointsHead>(store::parse_points_head(file, file.size()))) {
    auto rest = file.subspan(head.bytes());
    for (const auto& block : head.blocks) {
      blocks.emplace_back(rest.begin(), rest.begin() + block.bytes);
      rest = rest.subspan(block.bytes);
    }
  }
  Bytes file() const {
    // As long as it must be for these blocks, whatever it says.
    constexpr std::size_t entry_bytes = 12;
    const std::size_t head_bytes = head.bytes() - head.block_count() * entry_bytes + blocks.size() * entry_bytes;
    auto sealed = head;
    Bytes bytes(head_bytes);
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      sealed.blocks[i] = {static_cast<std::uint32_t>(blocks[i].size()), checksum(blocks[i], i)};
      bytes.insert(bytes.end(), blocks[i].begin(), blocks[i].end());
    }
    store::write_points_head(sealed, std::span(bytes).first(head_bytes));
    return bytes;
  }
  Bytes& block(const std::string& place) {
    for (const auto& column : head.columns())
      if (head.place(column) == place) return blocks[column.first_block];
    ADD_FAILURE() << place;
    return blocks[0];
  }
};

// 300 points: some planes are packed, others not.
PointsTile sample_tile(int dimension) {
  auto tile = uniform_tile(dimension, 300, 100);
  tile.cells = 500;
  for (std::size_t i = 0; i < tile.points.size(); ++i) tile.points[i].y = static_cast<double>(i % 50) / 100;
  std::vector<double> heights;
  for (int i = 0; i < 100; ++i) heights.push_back(i < 60 ? i * 0.01 + 7e5 : 1.0 / (i + 1));
  add_attribute(tile, {"height", AttributeType::f64}, heights);
  add_attribute<std::int8_t>(tile, {"kind", AttributeType::i8}, {-1, 5, 3});
  add_attribute<float>(tile, {"share", AttributeType::f32}, {0.5f, -0.25f});
  return tile;
}

class DamagedPoints : public testing::TestWithParam<int> {
 protected:
  Result<PointsTile> read(std::span<const std::byte> bytes) const {
    return parse_points_file(bytes, "tiles/000042.pts", tile_.tile);
  }
  void expect_corrupt(std::span<const std::byte> bytes, const std::string& says) const {
    const auto tile = read(bytes);
    ASSERT_FALSE(tile) << says;
    EXPECT_EQ(tile.error().code, Errc::corrupt);
    EXPECT_EQ(tile.error().where.substr(0, 18 + says.size()), "tiles/000042.pts, " + says);
  }

  PointsTile tile_ = sample_tile(GetParam());
  const std::vector<double> areas_ = std::vector<double>(tile_.cells, 1.5);
  const std::vector<std::byte> good_ = file_with_columns(
      tile_, std::vector<store::ColumnValues>{{true, {"area", AttributeType::f64}, std::as_bytes(std::span(areas_))}});
};
INSTANTIATE_TEST_SUITE_P(Dimensions, DamagedPoints, testing::Values(2, 3));

TEST_P(DamagedPoints, AreCorruptWhereverTheyAreCutOff) {
  ASSERT_TRUE(read(good_));
  const TemporaryFolder folder;
  const auto path = folder.path() / "a.pts";
  ASSERT_TRUE(write_whole(path, good_));
  for (std::size_t size = good_.size(); size-- > 0;) {
    const auto tile = read(std::span(good_).first(size));
    ASSERT_FALSE(tile) << size;
    ASSERT_EQ(tile.error().code, Errc::corrupt) << size;
    std::filesystem::resize_file(path, size);
    const auto ids = read_own_point_ids(path, tile_.tile);
    ASSERT_FALSE(ids) << size;
    ASSERT_EQ(ids.error().code, Errc::corrupt) << size;
  }
}

TEST_P(DamagedPoints, AreCorruptWhicheverByteIsChanged) {
  for (std::size_t at = 0; at < good_.size(); ++at) {
    auto bad = good_;
    bad[at] ^= std::byte{1} << (at * 5 % 8);
    const auto tile = read(bad);
    ASSERT_FALSE(tile) << at;
    ASSERT_EQ(tile.error().code, Errc::corrupt) << at;
  }
}

// Behind its checksum: every byte of every block. What is read then may be wrong, but it is as long as the head says,
// and what was not refused is not what was written.
TEST_P(DamagedPoints, DoNoHarmWhenTheSumsAreForged) {
  const Forged good(good_);
  std::size_t refused = 0, other = 0;
  for (std::size_t b = 0; b < good.blocks.size(); ++b)
    for (std::size_t at = 0; at < good.blocks[b].size(); ++at)
      for (const unsigned change : {1u, 0x80u, 0xffu}) {
        Forged bad = good;
        bad.blocks[b][at] ^= std::byte{static_cast<unsigned char>(change)};
        const auto tile = read(bad.file());
        if (!tile) {
          ASSERT_EQ(tile.error().code, Errc::corrupt) << b << " " << at;
          ++refused;
          continue;
        }
        ++other;
        ASSERT_EQ(tile.value().points.size(), tile_.points.size());
        ASSERT_EQ(tile.value().rows.size(), tile_.rows.size());
      }
  EXPECT_GT(refused, 100u);
  EXPECT_GT(other, 1000u);
}

TEST_P(DamagedPoints, AreCorruptWithAHeadThatCannotBe) {
  const auto expect = [&](const std::function<void(Forged&)>& change, const std::string& says) {
    Forged forged(good_);
    change(forged);
    expect_corrupt(forged.file(), says);
  };
  expect([](Forged& f) { f.head.tile = TileId{41}; }, "head: is that of tile 41");
  expect([](Forged& f) { f.head.dimension = 4; }, "head: has 4 dimensions");
  expect([](Forged& f) { f.head.own = std::uint64_t{1} << 31u; }, "head: announces too many points");
  expect([](Forged& f) { f.head.named[0].as.name = "id"; }, "head: has impossible columns");
  expect([](Forged& f) { f.head.named[0].as.name = "kind"; }, "head: has impossible columns");
  expect([](Forged& f) { f.head.named[0].as.name = ""; }, "head: has impossible columns");
  expect([](Forged& f) { f.head.named[0].as.name = "a\n"; }, "head: has impossible columns");
  expect([](Forged& f) { f.head.named[0].as.type = static_cast<AttributeType>(10); }, "head: has impossible columns");
  expect([](Forged& f) { f.head.named[3].as.name = "tile"; }, "head: has impossible columns");
  expect([](Forged& f) { f.head.named[3].of_cells = false; },
         "head: has a number of blocks that does not fit its rows");
  expect([](Forged& f) { f.head.cells = 0; }, "head: has a number of blocks that does not fit its rows");
  expect([](Forged& f) { f.head.cells += 1 << 20; }, "head: has a number of blocks that does not fit its rows");
  expect([](Forged& f) { f.head.cells = (std::uint64_t{1} << 31u) + 1; }, "head: announces too many cells");
  expect([](Forged& f) { f.head.foreign = 0; }, "head: has a number of blocks that does not fit its rows");
  expect([](Forged& f) { f.head.own += 1 << 20; }, "head: has a number of blocks that does not fit its rows");
  auto longer = Forged(good_).file();
  longer.push_back({});
  expect_corrupt(longer, "head: says that the blocks end at byte " + std::to_string(good_.size()) +
                             ", which is not the end of the file");
  auto other = Forged(good_).file();
  other[15] = std::byte{'1'};
  expect_corrupt(other, "head: is damaged, or not that of a file of points");
  expect_corrupt({}, "head: is damaged, or not that of a file of points");
  EXPECT_FALSE(parse_points_file(good_, "a.pts", TileId{41}));
}

TEST_P(DamagedPoints, AreCorruptWithValuesThatCannotBe) {
  const auto expect = [&](const std::function<void(PointsTile&)>& change, const std::string& says) {
    PointsTile tile = tile_;
    change(tile);
    expect_corrupt(points_file_bytes(view_of(tile)), says);
  };
  expect([](PointsTile& t) { t.points[7].x = std::numeric_limits<double>::infinity(); },
         "points: point 7 is not finite");
  expect([](PointsTile& t) { t.points[8].y = std::numeric_limits<double>::quiet_NaN(); },
         "points: point 8 is not finite");
  expect([](PointsTile& t) { t.points[299].y = -0.0; }, "points: point 299 is at -0");
  expect([](PointsTile& t) { t.owners[250] = t.tile; },
         "points: point 250 belongs to the tile, but stands among the foreign points");
}

TEST_P(DamagedPoints, AreCorruptWithBlocksThatNobodyWrites) {
  const auto expect = [&](const std::string& place, const std::function<void(Bytes&)>& change,
                          const std::string& says) {
    Forged forged(good_);
    change(forged.block(place));
    expect_corrupt(forged.file(), place + ", block 0: " + says);
  };
  constexpr std::size_t rows = 200, head = 10;
  const auto integers = [](std::uint8_t relative, const std::vector<Bytes>& planes, std::uint8_t base = 7) {
    Bytes block{std::byte{relative}, static_cast<std::byte>(planes.size()), std::byte{base}};
    block.resize(head);
    for (const Bytes& plane : planes) {
      const auto size = bytes_of(std::vector{static_cast<std::uint32_t>(plane.size())});
      block.insert(block.end(), size.begin(), size.end());
    }
    for (const Bytes& plane : planes) block.insert(block.end(), plane.begin(), plane.end());
    return block;
  };
  const auto becomes = [](const Bytes& block) { return [block](Bytes& old) { old = block; }; };
  const auto packed = [](std::size_t size) {
    const Bytes plain(size, std::byte{1});
    Bytes frame(ZSTD_compressBound(size));
    frame.resize(ZSTD_compress(frame.data(), frame.size(), plain.data(), size, 1));
    return frame;
  };
  const auto joined = [](Bytes a, const Bytes& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
  };
  Bytes plain(rows, std::byte{5});
  const std::string id = "own points, id", kind = "own points, attribute 'kind'";
  const std::string height = "own points, attribute 'height'", share = "own points, attribute 'share'";
  const std::string area = "cells, column 'area'";
  expect(id, becomes({}), "ends too early");
  expect(
      id, [](Bytes& block) { block.resize(head - 1); }, "ends too early");
  expect(
      id, [](Bytes& block) { block.resize(head + 3); }, "ends too early");
  expect(
      id, [](Bytes& block) { block.pop_back(); }, "has a plane of a size that it cannot have");
  expect(
      id, [](Bytes& block) { block.push_back({}); }, "has bytes after its end");
  expect(
      id, [](Bytes& block) { block[0] = std::byte{2}; }, "is coded in an unknown way");
  expect(
      id, [](Bytes& block) { block[1] = std::byte{9}; }, "is coded in an unknown way");
  expect(id, becomes(integers(1, {})), "is coded in an unknown way");
  expect(id, becomes(integers(0, {{}})), "has a plane of a size that it cannot have");
  expect(id, becomes(integers(0, {Bytes(rows + 1)})), "has a plane of a size that it cannot have");
  expect(id, becomes(integers(0, {Bytes(rows - 1)})), "has a plane that cannot be unpacked");
  expect(id, becomes(integers(0, {packed(rows - 1)})), "has a plane that cannot be unpacked");
  expect(id, becomes(integers(0, {packed(rows + 1)})), "has a plane that cannot be unpacked");
  expect(id, becomes(integers(0, {packed(1 << 20)})), "has a plane that cannot be unpacked");
  expect(id, becomes(integers(0, {joined(packed(rows), packed(1))})), "has a plane that cannot be unpacked");
  expect(id, becomes(integers(0, {joined(packed(100), packed(100))})), "has a plane that cannot be unpacked");
  expect(id, becomes(integers(0, {Bytes(rows)})), "has a plane of zeros, which is never written");
  expect(id, becomes(integers(0, {plain})), "does not contain the least number that it announces");
  expect(id, becomes(integers(1, {plain})), "does not begin with the first number that it announces");
  plain[0] = std::byte{0};
  expect(kind, becomes(integers(0, {plain}, 252)), "has a value too large for its type");
  expect(share, becomes(integers(0, {plain, plain, plain, plain, plain})), "has a value too large for its type");
  expect(height, becomes({}), "ends too early");
  expect(area, becomes({}), "ends too early");
  expect(area, becomes(joined({std::byte{0}}, integers(0, {plain}))), "has a plane that cannot be unpacked");
  for (const unsigned char code : {101, 128, 179, 255})
    expect(
        height, [&](Bytes& block) { block[0] = std::byte{code}; }, "is coded in an unknown way");
  expect(height, becomes(joined({std::byte{1}}, integers(0, {plain}))), "has a multiple that is too large");
  expect(
      height, [](Bytes& block) { block.pop_back(); }, "has a plane of a size that it cannot have");
  // What is right, made the same way.
  Forged forged(good_);
  forged.block(id) = integers(0, {plain});
  const auto tile = read(forged.file());
  ASSERT_TRUE(tile) << tile.error().where;
  EXPECT_EQ(tile.value().ids[0], PointId{7});
  EXPECT_EQ(tile.value().ids[1], PointId{12});
}

TEST(PointsFile, ThatIsMissingIsNoDamage) {
  const TemporaryFolder folder;
  EXPECT_EQ(read_points_file(folder.path() / "a.pts", TileId{1}, {}).error().code, Errc::io);
  EXPECT_EQ(read_own_point_ids(folder.path(), TileId{1}).error().code, Errc::io);
}

}  // namespace
}  // namespace tessera::test
