// Tiles as files of points: what is read is what was written, bit for bit, and small.
#include "src/result/store/points_file.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <string>

#include "src/base/files/whole_file.h"
#include "src/result/store/integer_block.h"
#include "tests/store/points_testing.h"
#include "tests/store/sample_result.h"

namespace tessera::test {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

template <class List>
bool same_bits(const List& a, const List& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]) == 0);
}

void expect_same(const PointsTile& read, const PointsTile& tile) {
  EXPECT_EQ(read.dimension, tile.dimension);
  EXPECT_EQ(read.tile, tile.tile);
  EXPECT_EQ(read.own, tile.own);
  EXPECT_EQ(read.cells, tile.cells);
  EXPECT_TRUE(same_bits(read.points, tile.points));
  EXPECT_EQ(read.ids, tile.ids);
  EXPECT_EQ(read.owners, tile.owners);
  EXPECT_EQ(read.schema, tile.schema);
  EXPECT_TRUE(same_bits(read.rows, tile.rows));
}

// Bytes of the file, which is read back.
std::size_t expect_round_trip(const PointsTile& tile) {
  const auto bytes = points_file_bytes(view_of(tile));
  const auto read = parse_points_file(bytes, "a.pts", tile.tile);
  EXPECT_TRUE(read) << (read ? "" : read.error().where);
  if (read) expect_same(read.value(), tile);
  return bytes.size();
}

double bytes_a_point(const PointsTile& tile) {
  return static_cast<double>(expect_round_trip(tile)) / static_cast<double>(tile.points.size());
}

class PointsFile : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Dimensions, PointsFile, testing::Values(2, 3));

TEST_P(PointsFile, HoldsUniformPointsOfSeveralBlocks) {
  const int dimension = GetParam();
  for (const std::size_t n : {store::block_rows - 1, store::block_rows, store::block_rows + 1, 3 * store::block_rows})
    expect_round_trip(uniform_tile(dimension, n, n / 3));
  // 53 bits a coordinate, of which the order tells some, 20 bits an id, owners.
  EXPECT_LT(bytes_a_point(uniform_tile(dimension, 100'000, 10'000)), dimension == 2 ? 15.7 : 22.4);
}

TEST_P(PointsFile, HoldsFewPoints) {
  for (std::size_t n = 1; n < 20; ++n)
    for (std::size_t foreign = 0; foreign <= n; ++foreign) expect_round_trip(uniform_tile(GetParam(), n, foreign));
  expect_round_trip(points_tile(GetParam(), {}, 0));
  EXPECT_LT(expect_round_trip(uniform_tile(GetParam(), 1, 0)), 200u);
}

// LAS: X * scale + offset, rounded twice, or once.
TEST_P(PointsFile, HoldsPointsOfAGridSmall) {
  for (const double offset : {0.0, 500'000.0, -6'861'000.25})
    for (const double scale : {0.01, 0.001, 0.5, 1.0, 0.0001, 0.25, 1e-7}) {
      std::mt19937 random(3);
      std::vector<Point> points(50'000);
      for (std::size_t i = 0; i < points.size(); ++i) {
        const auto at = [&](std::size_t step) {
          return static_cast<double>(1000 + step + random() % 16) * scale + offset;
        };
        points[i] = without_negative_zero({at(i / 100), at(i % 100), at(i % 1000)});
      }
      const auto tile = points_tile(GetParam(), points, 0);
      EXPECT_LT(bytes_a_point(tile), 2.7 + GetParam() * 1.2) << scale << " " << offset;
    }
}

TEST(PointsFile, HoldsDecimalsFromTextSmall) {
  for (const double one : {1.0, 10.0, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9}) {
    std::mt19937 random(5);
    std::vector<Point> points(20'000);
    for (Point& p : points)
      p = {static_cast<double>(random() % 200 + 5'000'000) / one, -static_cast<double>(random() % 200 + 1) / one, 0};
    EXPECT_LT(bytes_a_point(points_tile(2, points, 0)), 4.7) << one;
  }
}

TEST(PointsFile, HoldsCoordinatesOfEverySize) {
  std::mt19937_64 random(7);
  std::vector<Point> points(10'000);
  for (Point& p : points)
    for (int axis = 0; axis < 3; ++axis) {
      do {
        p[axis] = std::bit_cast<double>(random());
      } while (!std::isfinite(p[axis]));
    }
  constexpr double denormal = std::numeric_limits<double>::denorm_min();
  points[0] = {denormal, -denormal, 0};
  points[1] = {std::numeric_limits<double>::max(), std::numeric_limits<double>::lowest(), 1e-310};
  expect_round_trip(points_tile(3, points, 100));
  for (std::size_t i = 0; i < points.size(); ++i)
    points[i] = {static_cast<double>(i % 100) * denormal, -static_cast<double>(i + 1) * denormal,
                 0x1p53 + static_cast<double>(2 * i)};
  EXPECT_LT(bytes_a_point(points_tile(3, points, 0)), 8);
  for (std::size_t i = 0; i < points.size(); ++i)
    points[i] = {9007199254740991.0 - static_cast<double>(i), static_cast<double>(i) * 0x1p-53,
                 2251799813685247.5 - static_cast<double>(i)};
  EXPECT_LT(bytes_a_point(points_tile(3, points, 0)), 8);
}

TEST(PointsFile, HoldsEveryTypeOfAttributeBitForBit) {
  std::mt19937_64 random(11);
  auto tile = uniform_tile(3, 3000, 500);
  const auto of_type = [&]<class T>(const std::string& name, AttributeType type, T) {
    std::vector<T> values(1000);
    for (T& value : values) {
      const std::uint64_t bits = random();
      std::memcpy(&value, &bits, sizeof value);
    }
    values[0] = std::numeric_limits<T>::lowest();
    values[1] = std::numeric_limits<T>::max();
    values[2] = T{};
    add_attribute(tile, {name, type}, values);
  };
  of_type("a", AttributeType::u8, std::uint8_t{});
  of_type("b", AttributeType::i8, std::int8_t{});
  of_type("c", AttributeType::u16, std::uint16_t{});
  of_type("d", AttributeType::i16, std::int16_t{});
  of_type("e", AttributeType::u32, std::uint32_t{});
  of_type("f", AttributeType::i32, std::int32_t{});
  of_type("g", AttributeType::u64, std::uint64_t{});
  of_type("h", AttributeType::i64, std::int64_t{});
  of_type("i", AttributeType::f32, float{});
  of_type("j", AttributeType::f64, double{});
  expect_round_trip(tile);
}

// Zeros of both signs, infinities, NaNs with what they carry, quiet and not, among heights of a grid.
TEST(PointsFile, HoldsDoublesThatAreNoNumbers) {
  const auto nan = [](std::uint64_t bits) { return std::bit_cast<double>(0x7ff0000000000000 | bits); };
  for (const std::size_t between : {0, 10, 1000}) {
    std::vector<double> values;
    for (const double odd : {0.0, -0.0, infinity, -infinity, nan(1), nan(0xfffffffffffff), nan(0x8000000000000),
                             -nan(0x8000000000123), 5e-324, -5e-324, 1e308, -9999.0, 1e30}) {
      values.push_back(odd);
      for (std::size_t i = 0; i < between; ++i) values.push_back(static_cast<double>(i * 7 % 100) / 100);
    }
    auto tile = uniform_tile(2, 20'000, 0);
    const std::size_t without = points_file_bytes(view_of(tile)).size();
    add_attribute(tile, {"height", AttributeType::f64}, values);
    const std::size_t with = expect_round_trip(tile);
    if (between == 1000) {
      EXPECT_LT(with - without, 25'000u);
    }
    tile.schema.clear();
    tile.rows.clear();
    std::vector<float> floats;
    for (const double value : values) floats.push_back(static_cast<float>(value));
    floats[4] = std::bit_cast<float>(0x7f800001u);
    add_attribute(tile, {"height", AttributeType::f32}, floats);
    expect_round_trip(tile);
  }
}

TEST(PointsFile, HoldsWhatIsEqualOrCountsForNothing) {
  auto tile = uniform_tile(3, 50'000, 0);
  for (std::size_t i = 0; i < tile.ids.size(); ++i) tile.ids[i] = {17 + i};
  const std::size_t without = expect_round_trip(tile);
  add_attribute<double>(tile, {"same", AttributeType::f64}, {std::bit_cast<double>(0xfff8000000000001)});
  add_attribute<std::int16_t>(tile, {"minus", AttributeType::i16}, {-3});
  add_attribute<float>(tile, {"third", AttributeType::f32}, {1.0f / 3});
  EXPECT_LT(expect_round_trip(tile) - without, 400u);
  tile.ids.assign(tile.ids.size(), PointId{std::numeric_limits<std::uint64_t>::max()});
  EXPECT_LE(expect_round_trip(tile), without + 400);
}

TEST(PointsFile, ManyAttributesMayHaveLongNames) {
  auto tile = uniform_tile(2, 10, 3);
  for (int i = 0; i < 40; ++i)
    add_attribute<std::uint8_t>(tile, {std::string(3000, 'n') + std::to_string(i), AttributeType::u8}, {1, 2, 3});
  const auto bytes = points_file_bytes(view_of(tile));
  EXPECT_GT(bytes.size(), 100'000u);
  const TemporaryFolder folder;
  ASSERT_TRUE(write_whole(folder.path() / "a.pts", bytes));
  expect_same(read_points_file(folder.path() / "a.pts", tile.tile, {}).value(), tile);
}

TEST(PointsFile, EqualTilesMakeEqualFiles) {
  const auto tile = uniform_tile(3, 100'000, 20'000);
  EXPECT_TRUE(same_bits(points_file_bytes(view_of(tile)), points_file_bytes(view_of(tile))));
}

TEST(PointsFile, IsReadAsFarAsAsked) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "000042.pts";
  auto tile = uniform_tile(3, 150'000, 20'000);
  tile.cells = 900'000;
  add_attribute<double>(tile, {"height", AttributeType::f64}, {0.25, 0.5, 0.75});
  ASSERT_TRUE(write_whole(path, points_file_bytes(view_of(tile))));
  expect_same(read_points_file(path, tile.tile, {}).value(), tile);

  const auto head = read_points_head(path, tile.tile).value();
  EXPECT_EQ(head.own, 130'000u);
  EXPECT_EQ(head.foreign, 20'000u);
  EXPECT_EQ(head.schema(), tile.schema);
  EXPECT_EQ(head.cells, tile.cells);
  const auto ids = read_own_point_ids(path, tile.tile).value();
  EXPECT_EQ(ids, std::vector(tile.ids.begin(), tile.ids.begin() + 130'000));
  tile.rows.clear();
  expect_same(read_points_file(path, tile.tile, {.rows = false}).value(), tile);
}

// Blocks that nobody asks for may be anything.
TEST(PointsFile, WhatIsNotAskedForIsNotRead) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "000042.pts";
  auto tile = uniform_tile(3, 1000, 20);
  add_attribute<double>(tile, {"height", AttributeType::f64}, {0.25, 0.5, 0.75});
  auto bytes = points_file_bytes(view_of(tile));
  bytes.back() ^= std::byte{1};
  ASSERT_TRUE(write_whole(path, bytes));
  EXPECT_FALSE(read_points_file(path, tile.tile, {}));
  EXPECT_TRUE(read_points_file(path, tile.tile, {.rows = false}));
  bytes[read_points_head(path, tile.tile).value().bytes()] ^= std::byte{1};
  ASSERT_TRUE(write_whole(path, bytes));
  EXPECT_FALSE(read_points_file(path, tile.tile, {.rows = false}));
  EXPECT_TRUE(read_own_point_ids(path, tile.tile));
}

}  // namespace
}  // namespace tessera::test
