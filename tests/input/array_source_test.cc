#include "src/input/npy/array_source.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "src/input/cloud/cloud.h"
#include "src/input/cloud/cloud_sample.h"
#include "src/input/reader.h"

namespace tessera {
namespace {

Result<Cloud> cloud_of(const std::vector<double>& coordinates, int dimension,
                       std::vector<std::string> attributes = {}) {
  CloudOptions options;
  options.dimension = dimension;
  options.attributes = std::move(attributes);
  return Cloud::open_source(array_source("the array", coordinates, dimension), std::move(options));
}

TEST(ArraySource, IsReadAsTheNumPyFileThatItWouldBe) {
  for (const int dimension : {2, 3}) {
    const auto d = static_cast<std::size_t>(dimension);
    std::vector<double> coordinates(d * 100'000);
    for (std::size_t i = 0; i < coordinates.size(); ++i) coordinates[i] = static_cast<double>(i) / 7;
    const auto reader = open_reader(array_source("the array", coordinates, dimension)).value();
    EXPECT_EQ(reader->info().dimension, dimension);
    EXPECT_EQ(reader->info().points, 100'000u);
    ASSERT_TRUE(reader->seek(99'998).value());
    PointBatch batch;
    ASSERT_TRUE(reader->next(batch));
    ASSERT_EQ(batch.points.size(), 2u);
    EXPECT_EQ(batch.points[1].y, coordinates[d * 99'999 + 1]);
    EXPECT_EQ(batch.points[1].z, dimension == 3 ? coordinates.back() : 0);
    EXPECT_EQ(reader->place(1), "row 99999");
  }
}

TEST(ArraySource, RowsOfNamedColumnsAreCoordinatesAndAttributes) {
  struct Row {
    double x, y, z;
    std::uint64_t mass;
  };
  const std::vector<Row> rows{{1, 2, 3, 7}, {4, 5, 6, 8}};
  const auto reader = open_reader(record_source("the array", std::as_bytes(std::span(rows)),
                                                "[('x', '<f8'), ('y', '<f8'), ('z', '<f8'), ('mass', '<u8')]", 2),
                                  {{"mass", AttributeType::u64}})
                          .value();
  PointBatch batch;
  ASSERT_TRUE(reader->next(batch));
  EXPECT_EQ(batch.points, (std::vector<Point>{{1, 2, 3}, {4, 5, 6}}));
  const std::vector<std::uint64_t> masses{7, 8};
  EXPECT_TRUE(std::ranges::equal(batch.rows, std::as_bytes(std::span(masses))));
}

TEST(ArraySource, EveryPartOfItCanBeRead) {
  const std::vector<double> coordinates{1, 2, 3, 4, 5, 6};
  const auto source = array_source("the array", coordinates, 3);
  std::vector<std::byte> whole(source->size());
  ASSERT_TRUE(source->read(0, whole));
  for (std::size_t begin = 0; begin <= whole.size(); ++begin) {
    for (std::size_t end = begin; end <= whole.size(); ++end) {
      std::vector<std::byte> part(end - begin);
      ASSERT_TRUE(source->read(begin, part));
      EXPECT_TRUE(std::equal(part.begin(), part.end(), whole.begin() + static_cast<std::ptrdiff_t>(begin)));
    }
  }
}

TEST(CloudOfASource, IsReadAndSampledAsOftenAsWanted) {
  std::vector<double> coordinates(3 * 70'000);
  for (std::size_t i = 0; i < coordinates.size(); ++i) coordinates[i] = static_cast<double>(i);
  const auto cloud = cloud_of(coordinates, 3).value();
  for (int round = 0; round < 2; ++round) {
    std::uint64_t next = 0;
    const auto counts = cloud.for_each_batch([&](CloudBatch& batch) -> Status {
      for (const LocalPoint& p : batch.points) {
        EXPECT_EQ(p.id.value, next);
        EXPECT_EQ(p.at.x, coordinates[3 * next++]);
      }
      return success();
    });
    EXPECT_EQ(counts.value().read, 70'000u);
  }
  EXPECT_GT(sample_cloud(cloud, 1000).value().size(), 500u);
}

TEST(CloudOfASource, ErrorsNameItAndTheRow) {
  const std::vector<double> coordinates{0, 0, 1, 1, std::numeric_limits<double>::infinity(), 2};
  const auto counts = cloud_of(coordinates, 2).value().for_each_batch([](CloudBatch&) { return success(); });
  ASSERT_FALSE(counts);
  EXPECT_EQ(counts.error().where.substr(0, 33), "the array, row 2: x is infinite (");
  EXPECT_EQ(cloud_of(coordinates, 3).value().files()[0].points, 2u);
  EXPECT_EQ(cloud_of(coordinates, 2, {"z"}).error().code, Errc::usage);
}

}  // namespace
}  // namespace tessera
