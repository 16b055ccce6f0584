// COPC by region and resolution: what is read is what reading everything and dropping the rest would leave.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include "src/input/cloud/cloud.h"
#include "src/input/cloud/cloud_sample.h"
#include "tests/input/laz_testing.h"
#include "tests/input/real_clouds.h"

namespace tessera::testing_io {
namespace {

struct Collected {
  std::vector<LocalPoint> points;
  CloudCounts counts;
};

Collected collect(const RealCloud& file, CloudOptions options) {
  const auto cloud = Cloud::open({file.path().string()}, std::move(options));
  EXPECT_EQ(sentence(cloud), "");
  Collected collected;
  const auto counts = cloud.value().for_each_batch([&](CloudBatch& batch) -> Status {
    collected.points.insert(collected.points.end(), batch.points.begin(), batch.points.end());
    return success();
  });
  EXPECT_EQ(sentence(counts), "");
  collected.counts = counts.value();
  return collected;
}

class CopcFile : public testing::TestWithParam<RealCloud> {};

TEST_P(CopcFile, CroppedIsTheWholeCloudWithoutThePointsOutside) {
  const auto all = collect(GetParam(), {}).points;
  std::mt19937_64 random(7);
  for (int trial = 0; trial < 12; ++trial) {
    // Between the coordinates of two points of the cloud: many boxes have points exactly on their sides.
    const Point a = all[random() % all.size()].at, b = all[random() % all.size()].at;
    Box box{{std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)},
            {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)}};
    const int dimension = trial % 3 == 0 ? 2 : 3;
    if (dimension == 2) box.lo.z = -INFINITY, box.hi.z = INFINITY;
    std::vector<LocalPoint> expected;
    for (auto p : all) {
      if (p.at.x < box.lo.x || p.at.x > box.hi.x || p.at.y < box.lo.y || p.at.y > box.hi.y || p.at.z < box.lo.z ||
          p.at.z > box.hi.z)
        continue;
      if (dimension == 2) p.at.z = 0;
      expected.push_back(p);
    }
    const auto cropped =
        collect(GetParam(), {.dimension = dimension, .crop = box, .threads = static_cast<unsigned>(1 + trial % 4)});
    EXPECT_EQ(cropped.points, expected) << "ids included";
    EXPECT_EQ(cropped.counts.read, all.size());
    EXPECT_EQ(cropped.counts.filtered, all.size() - expected.size());
  }
}

TEST_P(CopcFile, HasNoPointsInABoxBesideIt) {
  const auto none = collect(GetParam(), {.crop = Box{{1e8, 1e8, -INFINITY}, {2e8, 2e8, INFINITY}}});
  EXPECT_TRUE(none.points.empty());
  EXPECT_EQ(none.counts.read, none.counts.filtered);
  EXPECT_GT(none.counts.read, 0u);
}

// Every finer resolution adds levels; at the spacing of the root there is the root alone, and in the end everything.
TEST_P(CopcFile, GrowsLevelByLevelWithTheResolution) {
  const auto bytes_at = [&](std::uint64_t offset) {
    double value = 0;
    EXPECT_EQ(
        sentence(open_file(GetParam().path()).value()->read(offset, std::as_writable_bytes(std::span(&value, 1)))), "");
    return value;
  };
  const double spacing = bytes_at(375 + 54 + 32);
  const auto all = collect(GetParam(), {}).points;
  std::vector<LocalPoint> coarser;
  const auto by_id = [](const LocalPoint& a, const LocalPoint& b) { return a.id < b.id; };
  for (int level = 0; level < 12; ++level) {
    const auto now = collect(GetParam(), {.resolution = std::ldexp(spacing, -level) * 1.000001}).points;
    EXPECT_TRUE(std::includes(now.begin(), now.end(), coarser.begin(), coarser.end(), by_id));
    if (level == 0) {
      EXPECT_GT(now.size(), 0u);
      EXPECT_LT(now.size(), all.size());
      EXPECT_EQ(now, collect(GetParam(), {.resolution = 1e300}).points);
    }
    coarser = now;
  }
  EXPECT_EQ(coarser, all);
}

TEST_P(CopcFile, SamplesOnlyTheRegion) {
  const auto all = collect(GetParam(), {}).points;
  const Point at = all[all.size() / 2].at;
  const Box box{{at.x - 5, at.y - 5, at.z - 5}, {at.x + 5, at.y + 5, at.z + 5}};
  const auto cloud = Cloud::open({GetParam().path().string()}, {.crop = box});
  const auto sample = sample_cloud(cloud.value(), 1000);
  ASSERT_EQ(sentence(sample), "");
  EXPECT_FALSE(sample.value().empty());
  for (const auto& p : sample.value()) EXPECT_LE(std::abs(p.x - at.x), 5);
}

INSTANTIATE_TEST_SUITE_P(Copc, CopcFile,
                         testing::ValuesIn(real_clouds({"lone_star_part.copc.laz", "lion_takanawa_part.copc.laz",
                                                        "ellipsoid.copc.laz"},
                                                       {"lone_star.copc.laz", "lion_takanawa.copc.laz"})));

// Counts the bytes that are asked of a file.
class CountingSource : public ByteSource {
 public:
  CountingSource(std::unique_ptr<ByteSource> source, std::uint64_t& bytes)
      : source_(std::move(source)), bytes_(bytes) {}
  const std::filesystem::path& path() const override { return source_->path(); }
  std::uint64_t size() const override { return source_->size(); }
  std::int64_t modified_ns() const override { return source_->modified_ns(); }
  Status read(std::uint64_t offset, std::span<std::byte> out) const override {
    bytes_ += out.size();
    return source_->read(offset, out);
  }
  Status check_unchanged() const override { return source_->check_unchanged(); }

 private:
  std::unique_ptr<ByteSource> source_;
  std::uint64_t& bytes_;
};

std::uint64_t bytes_read(const std::filesystem::path& path, const std::vector<Attribute>& schema,
                         const ReadHints& hints) {
  std::uint64_t bytes = 0;
  auto source = std::make_unique<CountingSource>(open_file(path).value(), bytes);
  auto reader = open_reader(std::move(source), schema, hints);
  EXPECT_EQ(sentence(reader), "");
  EXPECT_EQ(sentence(read_whole(*reader.value())), "");
  return bytes;
}

// The compressed bytes of the root, the first entry of the hierarchy.
std::uint64_t root_bytes(const std::filesystem::path& path) {
  const auto source = open_file(path).value();
  std::array<std::byte, 8> raw{};
  EXPECT_EQ(sentence(source->read(375 + 54 + 40, raw)), "");
  EXPECT_EQ(sentence(source->read(load<std::uint64_t>(raw.data()) + 24, raw)), "");
  return load<std::uint32_t>(raw.data());
}

// Each with how many times as much is read without the corner of 2 m, and without the resolution, at least.
struct Shares {
  RealCloud file;
  std::uint64_t corner, root;
  friend std::ostream& operator<<(std::ostream& out, const Shares& shares) { return out << shares.file; }
};

std::vector<Shares> lone_stars() {
  std::vector<Shares> shares;
  for (const RealCloud& file : real_clouds({"lone_star_part.copc.laz"}, {"lone_star.copc.laz"})) {
    const bool whole = file.folder == more_clouds;  // has more nodes beside the root
    shares.push_back({.file = file, .corner = whole ? 3u : 2u, .root = whole ? 4u : 2u});
  }
  return shares;
}

class CopcBytes : public testing::TestWithParam<Shares> {};

TEST_P(CopcBytes, AreReadOnlyOfTheNodesAndLayersThatAreAskedFor) {
  const auto path = GetParam().file.path();
  const auto size = std::filesystem::file_size(path);
  const std::vector<Attribute> intensity{{"intensity", AttributeType::u16}};
  const auto coordinates = bytes_read(path, {}, {});
  const auto with_intensity = bytes_read(path, intensity, {});
  EXPECT_LT(coordinates, with_intensity);
  EXPECT_LT(with_intensity, size + 4096);
  const Box corner{{515380, 4918350, -INFINITY}, {515382, 4918352, INFINITY}};
  EXPECT_LT(bytes_read(path, {}, {.crop = corner}), coordinates / GetParam().corner);
  EXPECT_LT(bytes_read(path, {}, {.resolution = 1e300}), coordinates / GetParam().root);
  const auto all = open_reader(path).value()->info().attributes;
  EXPECT_LT(bytes_read(path, all, {.resolution = 1e300}), root_bytes(path) + 8192) << "head, hierarchy and table";
}

INSTANTIATE_TEST_SUITE_P(Copc, CopcBytes, testing::ValuesIn(lone_stars()));

TEST(Laz, RefusesAResolutionForFilesWithoutLevels) {
  const auto cloud = Cloud::open({(clouds / "lone_star_begin.laz").string()}, {.resolution = 1});
  ASSERT_TRUE(cloud.has_error());
  EXPECT_EQ(cloud.error().code, Errc::usage);
  EXPECT_NE(cloud.error().where.find("lone_star_begin.laz: is neither COPC nor EPT"), std::string::npos);
}

class Seekable : public testing::TestWithParam<RealCloud> {};

TEST_P(Seekable, SeeksToAnyPoint) {
  auto reader = open_reader(GetParam().path(), {}, {.threads = 3});
  const auto all = read_whole(*reader.value()).value().points;
  std::mt19937_64 random(3);
  PointBatch batch;
  for (int trial = 0; trial < 40; ++trial) {
    const std::uint64_t at = random() % all.size();
    const std::size_t most = trial % 5 == 0 ? SIZE_MAX : 1 + random() % 300;
    ASSERT_TRUE(reader.value()->seek(at).value());
    for (std::uint64_t begin = at, round = 0; round < 3; ++round) {
      ASSERT_EQ(sentence(reader.value()->next(batch, most)), "");
      ASSERT_LE(batch.points.size(), most);
      ASSERT_TRUE(
          std::equal(batch.points.begin(), batch.points.end(), all.begin() + static_cast<std::ptrdiff_t>(begin)));
      if (batch.points.empty()) break;
      EXPECT_EQ(reader.value()->place(0), "record " + std::to_string(begin));
      begin += batch.points.size();
    }
  }
  ASSERT_TRUE(reader.value()->seek(all.size() + 5).value());
  ASSERT_EQ(sentence(reader.value()->next(batch)), "");
  EXPECT_TRUE(batch.points.empty());
}

INSTANTIATE_TEST_SUITE_P(Laz, Seekable,
                         testing::ValuesIn(real_clouds({"lone_star_begin.laz", "lone_star_part.copc.laz"},
                                                       {"bcts_1.laz", "lone_star.copc.laz"})));

}  // namespace
}  // namespace tessera::testing_io
