#include "src/result/store/duplicate_rows.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "src/base/files/names.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/result/store/manifest.h"
#include "tests/store/sample_result.h"

namespace tessera {
namespace {

using test::TemporaryFolder;

// Rows of one byte to several pieces.
std::vector<std::byte> row_of(PointId id, std::size_t width) {
  std::vector<std::byte> row(width);
  for (std::size_t i = 0; i < width; ++i) row[i] = static_cast<std::byte>(id.value * 31 + i);
  return row;
}

std::vector<Attribute> schema_of(std::size_t width) {
  std::vector<Attribute> schema;
  for (std::size_t i = 0; i < width; ++i) schema.push_back({"a" + std::to_string(i), AttributeType::u8});
  return schema;
}

class RowsOfDuplicates : public ::testing::TestWithParam<std::size_t> {};

TEST_P(RowsOfDuplicates, AreReadAsTheyWereWrittenWhateverTheirOrderAndTheMemory) {
  const std::size_t width = GetParam();
  const TemporaryFolder folder;
  Manifest manifest =
      test::store_sample(folder.path(), test::sample_tiles(test::sample_points(test::Shape::uniform, 2, 50), 2, 1),
                         {.schema = schema_of(width)});
  std::mt19937_64 random(1);
  std::set<std::uint64_t> ids;
  while (ids.size() < 5000) ids.insert(100 + random() % 1'000'000);
  std::vector<DuplicatePair> pairs;
  for (const std::uint64_t id : ids) pairs.push_back({PointId{id}, PointId{3}});
  auto shuffled = pairs;
  std::shuffle(shuffled.begin(), shuffled.end(), random);
  DuplicateRowSort rows(folder.path(), 1, width);  // the least memory
  for (const DuplicatePair& pair : shuffled) ASSERT_TRUE(rows.push(pair.duplicate, row_of(pair.duplicate, width)));
  ASSERT_TRUE(finish_store(folder.path(), manifest, pairs, &rows));
  const Manifest read = read_manifest(folder.path()).value();
  EXPECT_EQ(read.duplicate_rows_xxh3, manifest.duplicate_rows_xxh3);
  EXPECT_EQ(store::manifest_to_text(read), store::manifest_to_text(manifest));
  const auto kept = DuplicateRows::open(folder.path(), read);
  ASSERT_TRUE(kept) << kept.error().where;
  ASSERT_TRUE(kept.value());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto row = kept.value()->row(i);
    ASSERT_EQ(std::vector(row.begin(), row.end()), row_of(pairs[i].duplicate, width));
  }
}

INSTANTIATE_TEST_SUITE_P(Widths, RowsOfDuplicates, ::testing::Values(1, 9, 20, 21, 40, 63));

TEST(RowsOfDuplicatesOf, AResultWithoutThemAreNothing) {
  const TemporaryFolder folder;
  Manifest manifest =
      test::store_sample(folder.path(), test::sample_tiles(test::sample_points(test::Shape::uniform, 2, 50), 2, 1),
                         {.schema = schema_of(3)});
  DuplicateRowSort rows(folder.path(), 1, 3);
  ASSERT_TRUE(rows.push(PointId{200}, row_of(PointId{200}, 3)));
  ASSERT_TRUE(finish_store(folder.path(), manifest, std::vector<DuplicatePair>{{PointId{200}, PointId{3}}}, &rows));
  EXPECT_TRUE(is_there(duplicate_rows_file(folder.path())).value());
  ASSERT_TRUE(finish_store(folder.path(), manifest, std::vector<DuplicatePair>{{PointId{200}, PointId{3}}}));
  EXPECT_FALSE(is_there(duplicate_rows_file(folder.path())).value()) << "of the result before";
  const auto kept = DuplicateRows::open(folder.path(), read_manifest(folder.path()).value());
  ASSERT_TRUE(kept);
  EXPECT_FALSE(kept.value());
}

TEST(RowsOfDuplicatesOf, ADamagedFileAreRefused) {
  const TemporaryFolder folder;
  Manifest manifest =
      test::store_sample(folder.path(), test::sample_tiles(test::sample_points(test::Shape::uniform, 2, 50), 2, 1),
                         {.schema = schema_of(3)});
  DuplicateRowSort rows(folder.path(), 1, 3);
  ASSERT_TRUE(rows.push(PointId{200}, row_of(PointId{200}, 3)));
  ASSERT_TRUE(finish_store(folder.path(), manifest, std::vector<DuplicatePair>{{PointId{200}, PointId{3}}}, &rows));
  manifest.duplicates = 2;
  const auto other = DuplicateRows::open(folder.path(), manifest);
  ASSERT_FALSE(other);
  EXPECT_NE(other.error().where.find("must have the attributes of 2 duplicates, 3 bytes each"), std::string::npos);
  manifest.duplicates = 1;
  const auto bytes = row_of(PointId{201}, 3);
  ASSERT_TRUE(write_whole(duplicate_rows_file(folder.path()), bytes));
  const auto damaged = DuplicateRows::open(folder.path(), manifest);
  ASSERT_FALSE(damaged);
  EXPECT_EQ(damaged.error().code, Errc::corrupt);
  EXPECT_NE(damaged.error().where.find("is damaged: its checksum is"), std::string::npos);
}

// The source indices of inputs, where they are known.
TEST(Manifest, TellsWhichPointsCameFromWhichInput) {
  const TemporaryFolder folder;
  Manifest manifest =
      test::store_sample(folder.path(), test::sample_tiles(test::sample_points(test::Shape::uniform, 2, 50), 2, 1));
  manifest.inputs = {{"a.las", 1, 2, Manifest::Input::Ids{0, 30}}, {"b.las", 3, 4}};
  ASSERT_TRUE(finish_store(folder.path(), manifest, std::vector<DuplicatePair>()));
  const auto read = read_manifest(folder.path());
  ASSERT_TRUE(read) << read.error().where;
  EXPECT_EQ(read.value().inputs.at(0).ids, (Manifest::Input::Ids{0, 30}));
  EXPECT_FALSE(read.value().inputs.at(1).ids);
}

}  // namespace
}  // namespace tessera
