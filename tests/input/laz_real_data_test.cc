// Real LAS and LAZ files against the uncompressed twins that other programs made of them: record by record where the
// twin is there, or by the hashes that a manifest has of it.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "tests/input/laz_testing.h"
#include "tests/input/real_clouds.h"

namespace tessera::testing_io {
namespace {

nlohmann::json manifest_of(const std::filesystem::path& folder) {
  std::ifstream in(folder / "manifest.json");
  return nlohmann::json::parse(in);
}

// What manifest.json says of a file of tests/data/clouds.
struct Told {
  RealCloud file;
  std::size_t points = 0;
  int format = 0;
  std::uint16_t record_bytes = 0;
  std::string xyz_sha256, records_sha256;
  friend std::ostream& operator<<(std::ostream& out, const Told& told) { return out << told.file; }
};

std::vector<Told> told_files() {
  std::vector<Told> files;
  const auto manifest = manifest_of(clouds);
  for (const auto& [name, facts] : manifest.items()) {
    if (!facts.contains("records_sha256")) continue;
    files.push_back({.file = {clouds, name},
                     .points = facts["points"],
                     .format = facts["format"],
                     .record_bytes = facts["record_bytes"],
                     .xyz_sha256 = facts["xyz_sha256"],
                     .records_sha256 = facts["records_sha256"]});
  }
  return files;
}

class EveryCloud : public testing::TestWithParam<Told> {};

TEST_P(EveryCloud, HasTheRecordsOfItsTwinToTheLastBit) {
  const Told& told = GetParam();
  const auto read = read_records(told.file.path(), all_fields);
  ASSERT_EQ(sentence(read), "");
  const Records& records = read.value();
  EXPECT_EQ(records.header.point_format, told.format);
  ASSERT_EQ(records.header.record_bytes, told.record_bytes);
  EXPECT_EQ(records.size(), told.points);
  EXPECT_EQ(sha256(records.bytes), told.records_sha256);
}

TEST_P(EveryCloud, GivesTheSameIntegersWhenNothingElseIsWantedAndInSeveralThreads) {
  for (const std::uint32_t threads : {1, 4}) {
    const auto records = read_records(GetParam().file.path(), coordinates_only, {.threads = threads});
    ASSERT_EQ(sentence(records), "");
    EXPECT_EQ(records.value().size(), GetParam().points);
    EXPECT_EQ(xyz_sha256(records.value()), GetParam().xyz_sha256) << threads << " threads";
  }
}

// Its records are its twin's, as the first test says.
TEST_P(EveryCloud, IsOneCloudWithAllAttributesCompressedAndNot) {
  const auto schema = open_reader(GetParam().file.path()).value()->info().attributes;
  const auto read = read_path(GetParam().file.path(), schema);
  const auto twin = read_bytes(las_bytes(GetParam().file.path()), "twin.las", schema);
  ASSERT_EQ(sentence(read), "");
  ASSERT_EQ(sentence(twin), "");
  EXPECT_EQ(read.value().info.attributes, twin.value().info.attributes);
  EXPECT_EQ(read.value().points, twin.value().points);
  EXPECT_EQ(read.value().rows, twin.value().rows);
}

INSTANTIATE_TEST_SUITE_P(RealLaz, EveryCloud, testing::ValuesIn(told_files()));

TEST(RealClouds, HaveEveryPointFormatThatIsReadOfLasAndOfLaz) {
  std::set<int> compressed, plain;
  for (const Told& told : told_files()) {
    (told.file.path().extension() == ".laz" ? compressed : plain).insert(told.format);
  }
  const std::set<int> all{0, 1, 2, 3, 6, 7, 8};
  EXPECT_EQ(compressed, all);
  EXPECT_EQ(plain, all);
}

struct Twins {
  RealCloud laz;
  std::string las;
  std::filesystem::path las_path() const { return laz.folder / las; }
  friend std::ostream& operator<<(std::ostream& out, const Twins& twins) { return out << twins.laz; }
};

std::vector<Twins> all_twins() {
  std::vector<Twins> twins;
  for (const RealCloud& laz : real_clouds(
           {"laz_conformance/pdrf6-1.4.laz", "laz_conformance/pdrf7-v4-1.4.laz", "laz_perf/point-color.las.laz"},
           {"lidr_topography.laz", "lidr_megaplot.laz", "bcts_1.laz", "lone_star.laz", "lion_takanawa.copc.laz",
            "treels_pine_plot.laz"})) {
    std::string las = laz.name.substr(0, laz.name.size() - 4);  // .laz stands for .las, or behind it
    if (!las.ends_with(".las")) las += ".las";
    twins.push_back({laz, las});
  }
  return twins;
}

class EveryPair : public testing::TestWithParam<Twins> {};

TEST_P(EveryPair, HasTheSameRecordsToTheLastBit) {
  auto laz = read_records(GetParam().laz.path(), all_fields);
  auto las = read_records(GetParam().las_path(), all_fields);
  ASSERT_EQ(sentence(laz), "");
  ASSERT_EQ(sentence(las), "");
  const std::size_t stride = las.value().header.record_bytes;
  ASSERT_EQ(laz.value().header.record_bytes, stride);
  ASSERT_EQ(laz.value().size(), las.value().size());
  for (std::size_t i = 0; i < laz.value().bytes.size(); ++i) {
    ASSERT_EQ(laz.value().bytes[i], las.value().bytes[i]) << "record " << i / stride << " byte " << i % stride;
  }
}

TEST_P(EveryPair, GivesTheSameIntegersWhenNothingElseIsWantedAndInSeveralThreads) {
  const auto las = read_records(GetParam().las_path(), all_fields);
  for (const std::uint32_t threads : {1, 4}) {
    const auto laz = read_records(GetParam().laz.path(), coordinates_only, {.threads = threads});
    ASSERT_EQ(sentence(laz), "");
    ASSERT_EQ(laz.value().size(), las.value().size());
    for (std::size_t i = 0; i < laz.value().size(); ++i)
      for (std::size_t axis = 0; axis < 3; ++axis)
        ASSERT_EQ(laz.value().integer(i, axis), las.value().integer(i, axis)) << "record " << i << " axis " << axis;
  }
}

TEST_P(EveryPair, IsOneCloudWithAllAttributes) {
  const auto laz_info = open_reader(GetParam().laz.path()).value()->info();
  const auto las_info = open_reader(GetParam().las_path()).value()->info();
  EXPECT_EQ(laz_info.attributes, las_info.attributes);
  const auto& schema = laz_info.attributes;
  const auto laz = read_path(GetParam().laz.path(), schema);
  const auto las = read_path(GetParam().las_path(), schema);
  ASSERT_EQ(sentence(laz), "");
  EXPECT_EQ(laz.value().points, las.value().points);
  EXPECT_EQ(laz.value().rows, las.value().rows);
}

INSTANTIATE_TEST_SUITE_P(RealLaz, EveryPair, testing::ValuesIn(all_twins()));

// Every LAS and LAZ file of the other folder, where that is; EveryCloud does it for those that are always there.
struct Hashed {
  RealCloud file;
  std::size_t points = 0;
  std::string xyz_sha256;
  friend std::ostream& operator<<(std::ostream& out, const Hashed& hashed) { return out << hashed.file; }
};

std::vector<Hashed> hashed_files() {
  std::vector<Hashed> files;
  if (!has_more_clouds()) return files;
  const auto manifest = manifest_of(more_clouds);
  for (const auto& [name, set] : manifest.items())
    for (const auto& [file, facts] : set["files"].items())
      if (file.ends_with(".laz") || file.ends_with(".las"))
        files.push_back({{more_clouds, file}, set["n"], set["xyz_sha256"]});
  return files;
}

class HashedCloud : public testing::TestWithParam<Hashed> {};

TEST_P(HashedCloud, HasTheHashOfItsCoordinates) {
  const auto records = read_records(GetParam().file.path(), coordinates_only, {.threads = 2});
  ASSERT_EQ(sentence(records), "");
  EXPECT_EQ(records.value().size(), GetParam().points);
  EXPECT_EQ(xyz_sha256(records.value()), GetParam().xyz_sha256);
}

INSTANTIATE_TEST_SUITE_P(RealLaz, HashedCloud, testing::ValuesIn(hashed_files()));
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(HashedCloud);

}  // namespace
}  // namespace tessera::testing_io
