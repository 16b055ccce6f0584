// Columns that are added to files of points: where they stand, and that all else stays as it was.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <numeric>
#include <string>

#include "src/base/files/whole_file.h"
#include "src/result/store/integer_block.h"
#include "src/result/store/points_file.h"
#include "src/result/store/points_head.h"
#include "tests/store/points_testing.h"
#include "tests/store/sample_result.h"

namespace tessera::test {
namespace {

store::PointsHead head_of(std::span<const std::byte> file) {
  return std::get<store::PointsHead>(store::parse_points_head(file, file.size()));
}

template <class T>
store::ColumnValues column(bool of_cells, const std::string& name, AttributeType type, const std::vector<T>& values) {
  return {of_cells, {name, type}, std::as_bytes(std::span(values))};
}

class PointsColumns : public testing::Test {
 protected:
  PointsColumns() {
    tile_.cells = 2 * store::block_rows + 100;
    add_attribute<double>(tile_, {"height", AttributeType::f64}, {0.25, 0.5, 0.75});
    for (std::uint64_t i = 0; i < tile_.cells; ++i) volumes_.push_back(1.0 / static_cast<double>(i + 1));
    // As a mesh has them: foreign vertices by id. Each has its own id.
    for (std::size_t i = 0; i < tile_.own; ++i) ids_.push_back(tile_.ids[i].value);
    std::vector<PointId> foreign(tile_.ids.begin() + static_cast<std::ptrdiff_t>(tile_.own), tile_.ids.end());
    std::sort(foreign.begin(), foreign.end());
    for (const PointId id : foreign) ids_.push_back(id.value);
    kinds_.assign(tile_.cells, 3);
  }

  std::vector<store::ColumnValues> all() const {
    return {column(true, "volume", AttributeType::f64, volumes_), column(false, "same", AttributeType::u64, ids_),
            column(true, "kind", AttributeType::u8, kinds_)};
  }
  PointsTile read(std::span<const std::byte> file) const {
    return parse_points_file(file, "tiles/000042.pts", tile_.tile).value();
  }

  PointsTile tile_ = uniform_tile(3, 3 * store::block_rows, 2 * store::block_rows + 7);
  std::vector<double> volumes_;
  std::vector<std::uint64_t> ids_;
  std::vector<std::uint8_t> kinds_;
};

TEST_F(PointsColumns, AreReadBackAndVerticesHaveTheirs) {
  const auto read = this->read(file_with_columns(tile_, all()));
  EXPECT_EQ(read.cells, tile_.cells);
  EXPECT_EQ(read.cell_schema, (std::vector<Attribute>{{"volume", AttributeType::f64}, {"kind", AttributeType::u8}}));
  const auto volumes = std::as_bytes(std::span(volumes_)), kinds = std::as_bytes(std::span(kinds_));
  EXPECT_EQ(read.cell_columns,
            (std::vector<std::vector<std::byte>>{{volumes.begin(), volumes.end()}, {kinds.begin(), kinds.end()}}));
  EXPECT_EQ(read.schema, (std::vector<Attribute>{{"height", AttributeType::f64}, {"same", AttributeType::u64}}));
  ASSERT_EQ(read.ids, tile_.ids);
  for (std::size_t i = 0; i < read.ids.size(); ++i) {
    ASSERT_EQ(std::memcmp(&read.rows[i * 16], &tile_.rows[i * 8], 8), 0) << i;
    ASSERT_EQ(std::memcmp(&read.rows[i * 16 + 8], &read.ids[i], 8), 0) << i;
  }
}

TEST_F(PointsColumns, StandBehindBlocksThatStayAsTheyWere) {
  const auto before = points_file_bytes(view_of(tile_));
  const auto after = file_with_columns(tile_, all());
  const auto old_head = head_of(before), head = head_of(after);
  ASSERT_GT(head.blocks.size(), old_head.blocks.size());
  std::uint64_t bytes = 0;
  for (std::size_t i = 0; i < old_head.blocks.size(); ++i) {
    EXPECT_EQ(head.blocks[i].bytes, old_head.blocks[i].bytes);
    EXPECT_EQ(head.blocks[i].xxh3, old_head.blocks[i].xxh3);
    bytes += head.blocks[i].bytes;
  }
  EXPECT_EQ(old_head.bytes() + bytes, before.size());
  EXPECT_TRUE(
      std::ranges::equal(std::span(after).subspan(head.bytes(), bytes), std::span(before).subspan(old_head.bytes())));
}

TEST_F(PointsColumns, OneAfterTheOtherOrAtOnceAreTheSameFile) {
  const TemporaryFolder folder;
  const auto path = [&](std::size_t i) { return folder.path() / std::to_string(i); };
  ASSERT_TRUE(write_whole(path(0), points_file_bytes(view_of(tile_))));
  const auto columns = all();
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const store::TileCopy copy{.tile = tile_.tile, .from = path(i), .to = path(i + 1), .final_name = path(i + 1)};
    const auto written = store::copy_points_with_columns(copy, std::span(columns).subspan(i, 1), {});
    ASSERT_TRUE(written) << written.error().where;
    EXPECT_EQ(written.value().bytes, std::filesystem::file_size(path(i + 1)));
  }
  EXPECT_TRUE(std::ranges::equal(read_whole(path(columns.size())).value(), file_with_columns(tile_, columns)));
}

TEST_F(PointsColumns, OfAnotherNumberOfRowsAreRefused) {
  const TemporaryFolder folder;
  const auto from = folder.path() / "a", to = folder.path() / "b";
  ASSERT_TRUE(write_whole(from, points_file_bytes(view_of(tile_))));
  auto columns = all();
  for (auto& wrong : columns) {
    wrong.values = wrong.values.subspan(size_of(wrong.as.type));
    const store::TileCopy copy{.tile = tile_.tile, .from = from, .to = to, .final_name = to};
    const auto written = store::copy_points_with_columns(copy, std::span(&wrong, 1), {});
    ASSERT_FALSE(written);
    EXPECT_EQ(written.error().code, Errc::internal);
  }
}

TEST_F(PointsColumns, EachBlockThatIsDamagedIsTold) {
  const auto good = file_with_columns(tile_, all());
  const auto head = head_of(good);
  std::size_t told = 0;
  for (const auto& column : head.columns()) {
    for (std::uint64_t block = 0; block < column.blocks; ++block) {
      auto bad = good;
      std::uint64_t at = head.bytes();
      for (std::uint64_t i = 0; i < column.first_block + block; ++i) at += head.blocks[i].bytes;
      bad[at] ^= std::byte{1};
      const auto read = parse_points_file(bad, "tiles/000042.pts", tile_.tile);
      ASSERT_FALSE(read);
      EXPECT_EQ(read.error().code, Errc::corrupt);
      EXPECT_EQ(read.error().where,
                "tiles/000042.pts, " + head.place(column) + ", block " + std::to_string(block) + ": is damaged");
      ++told;
    }
  }
  EXPECT_EQ(told, head.blocks.size());
}

TEST_F(PointsColumns, AreNotReadWhenNobodyAsks) {
  const TemporaryFolder folder;
  auto file = file_with_columns(tile_, all());
  file.back() ^= std::byte{1};
  ASSERT_TRUE(write_whole(folder.path() / "a", file));
  EXPECT_FALSE(read_points_file(folder.path() / "a", tile_.tile, {}));
  const auto read = read_points_file(folder.path() / "a", tile_.tile, {.cell_columns = false});
  ASSERT_TRUE(read) << read.error().where;
  EXPECT_TRUE(read.value().cell_columns.empty());
  EXPECT_EQ(read.value().cell_schema.size(), 2u);
}

}  // namespace
}  // namespace tessera::test
