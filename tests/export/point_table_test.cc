// The parts of tables of points that small results do not reach: blocks of many ids, and limits of formats.
#include "src/result/export/point_table.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "src/result/export/ndnet.h"
#include "src/result/export/row_numbers.h"
#include "src/result/export/zobov.h"
#include "tests/store/sample_result.h"

namespace tessera::exports::test {
namespace {

namespace fs = std::filesystem;
using tessera::test::sample_points;
using tessera::test::sample_tiles;
using tessera::test::Shape;
using tessera::test::store_sample;
using tessera::test::TemporaryFolder;

// A row of the id and a value that follows from it, `stride` bytes long.
std::vector<std::byte> row_of(std::uint64_t id, std::size_t stride) {
  std::vector<std::byte> row(stride, static_cast<std::byte>(id * 7));
  std::memcpy(row.data(), &id, sizeof id);
  return row;
}

TEST(RowsById, LeaveInTheOrderOfTheirIdsWhateverTheOrderOfTheirComing) {
  const TemporaryFolder scratch;
  // With rows this long a block has some 80 ids, so there are many blocks.
  for (const std::size_t stride : {std::size_t{8}, std::size_t{24}, std::size_t{400'000}}) {
    const std::uint64_t ids = stride > 1000 ? 300 : 100'000;
    std::vector<std::uint64_t> order(ids);
    std::iota(order.begin(), order.end(), std::uint64_t{0});
    std::shuffle(order.begin(), order.end(), std::mt19937_64(1));
    order.resize(ids * 3 / 4);
    auto rows = RowsById::create(scratch.path(), ids, stride).value();
    for (const std::uint64_t id : order) ASSERT_TRUE(rows.push(row_of(id, stride)));
    std::sort(order.begin(), order.end());
    std::size_t next = 0;
    ASSERT_TRUE(rows.for_each([&](std::span<const std::byte> some) -> Status {
      EXPECT_EQ(some.size() % stride, 0U);
      for (std::size_t at = 0; at < some.size(); at += stride, ++next) {
        const auto expected = row_of(order.at(next), stride);
        EXPECT_TRUE(std::equal(expected.begin(), expected.end(), some.begin() + static_cast<std::ptrdiff_t>(at)));
      }
      return success();
    }));
    EXPECT_EQ(next, order.size());
  }
}

TEST(RowsById, IdsThatCannotBeAreDamage) {
  const TemporaryFolder scratch;
  auto rows = RowsById::create(scratch.path(), 10, 16).value();
  EXPECT_EQ(rows.push(row_of(10, 16)).error().code, Errc::corrupt);
  ASSERT_TRUE(rows.push(row_of(3, 16)));
  ASSERT_TRUE(rows.push(row_of(3, 16)));
  const auto given = rows.for_each([](auto) -> Status { return success(); });
  ASSERT_FALSE(given);
  EXPECT_EQ(given.error().code, Errc::corrupt);
  EXPECT_NE(given.error().where.find("source index 3"), std::string::npos);
}

TEST(RowNumbers, CountTheIdsBefore) {
  constexpr std::uint64_t ids = 1000;
  for (const unsigned one_in : {1U, 2U, 5U, 300U}) {
    std::mt19937 random(one_in);
    std::vector<PointId> chosen;
    for (std::uint64_t id = 0; id < ids; ++id)
      if (random() % one_in == 0) chosen.push_back({id});
    RowNumbers numbers(ids, chosen.size());
    for (const PointId id : chosen) numbers.add(id);
    for (std::uint32_t i = 0; i < chosen.size(); ++i) {
      EXPECT_TRUE(numbers.has(chosen[i]));
      EXPECT_EQ(numbers.of(chosen[i]), i);
    }
  }
}

// Writes the sample with a limit of numbers that is too small.
template <class Write>
Result<Exported> with_limit(const fs::path& out, std::uint64_t limit, const Write& write) {
  const auto tiles = TileSource::open(out).value();
  const ExportOptions options;
  const MeshSource source{.out = out,
                          .tiles = &tiles,
                          .manifest = tiles.manifest(),
                          .format = formats().front(),
                          .options = options,
                          .filter = CellFilter(CellSizes{})};
  return write(source, limit);
}

TEST(Limits, OfNumbersOf32BitsAreTold) {
  const TemporaryFolder folder, target;
  store_sample(folder.path(), sample_tiles(sample_points(Shape::uniform, 3, 60), 3, 2));
  const auto zobov = with_limit(folder.path(), 59, [&](const MeshSource& source, std::uint64_t limit) {
    return write_zobov_files(source, target.path() / "a.vol", ZobovNumbers::floats, limit);
  });
  ASSERT_FALSE(zobov);
  EXPECT_EQ(zobov.error().code, Errc::usage);
  EXPECT_NE(zobov.error().where.find("has 60 points, and the numbers in ZOBOV's files end at 59"), std::string::npos);
  const auto net = with_limit(folder.path(), 59, [&](const MeshSource& source, std::uint64_t limit) {
    return write_ndnet_file(source, target.path() / "a.ndnet", limit);
  });
  ASSERT_FALSE(net);
  EXPECT_EQ(net.error().code, Errc::usage);
  EXPECT_NE(net.error().where.find("60 vertices"), std::string::npos);
  EXPECT_NE(net.error().where.find("the numbers in an NDnet end at 59"), std::string::npos);
  EXPECT_TRUE(fs::is_empty(target.path()));
}

}  // namespace
}  // namespace tessera::exports::test
