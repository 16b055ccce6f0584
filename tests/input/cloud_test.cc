#include "src/input/cloud/cloud.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <functional>
#include <limits>
#include <set>
#include <string>

#include "src/input/cloud/cloud_sample.h"
#include "tests/input/las_file.h"

namespace tessera::testing_io {
namespace {

struct Collected {
  CloudCounts counts;
  std::vector<LocalPoint> points;
  Bytes rows;
};

Result<Collected> collect(const Cloud& cloud) {
  Collected all;
  BOOST_OUTCOME_TRY(counts, cloud.for_each_batch([&](CloudBatch& batch) -> Status {
    all.points.insert(all.points.end(), batch.points.begin(), batch.points.end());
    all.rows.insert(all.rows.end(), batch.rows.begin(), batch.rows.end());
    return success();
  }));
  all.counts = counts;
  return all;
}

Result<Collected> collect(const std::vector<std::string>& patterns, const CloudOptions& options = {}) {
  BOOST_OUTCOME_TRY(cloud, Cloud::open(patterns, options));
  return collect(cloud);
}

class CloudOfFiles : public testing::Test {
 protected:
  std::string file(const std::string& name, const std::string& text) const {
    return folder_.write(name, text).string();
  }
  std::string at(const std::string& name) const { return (folder_.path() / name).string(); }
  TempFolder folder_;
};

TEST_F(CloudOfFiles, NumbersThePointsOfAllFilesInTheOrderGivenAndGlobsInOrderOfName) {
  file("b2.xyz", "20 0 0\n");
  file("b10.xyz", "10 0 0\n11 0 0\n");
  file("a.xyz", "1 0 0\n");
  const auto all = collect({at("b*.xyz"), at("a.xyz")});
  ASSERT_EQ(sentence(all), "");
  const std::vector<LocalPoint> expected{{{10, 0, 0}, 0}, {{11, 0, 0}, 1}, {{20, 0, 0}, 2}, {{1, 0, 0}, 3}};
  EXPECT_EQ(all.value().points, expected);
  EXPECT_EQ(all.value().counts.read, 4u);
}

TEST_F(CloudOfFiles, TakesAnExistingNameLiterallyEvenIfItLooksLikeAPattern) {
  file("a[1].xyz", "1 0 0\n");
  file("a1.xyz", "2 0 0\n");
  EXPECT_EQ(collect({at("a[1].xyz")}).value().points[0].at.x, 1);
}

TEST_F(CloudOfFiles, RefusesWhatIsNotThereOrNotAFile) {
  EXPECT_EQ(sentence(collect({at("none.las")})), at("none.las") + ": cannot be opened: No such file or directory");
  EXPECT_EQ(collect({at("none.las")}).error().code, Errc::io);
  EXPECT_EQ(sentence(collect({at("*.las")})), at("*.las") + ": no file matches this pattern");
  file("empty.las", "");
  EXPECT_EQ(sentence(collect({at("empty.las")})), at("empty.las") + ": is empty");
  file("what.bin", "some bytes of no format");
  EXPECT_NE(sentence(collect({at("what.bin")})).find("unknown format"), std::string::npos);
  ASSERT_EQ(::mkfifo(at("pipe.xyz").c_str(), 0600), 0);
  EXPECT_NE(sentence(collect({at("pipe.xyz")})).find("is not a regular file"), std::string::npos);
  EXPECT_EQ(Cloud::open({}, {}).error().code, Errc::usage);
}

TEST_F(CloudOfFiles, RefusesAnUnreadableFile) {
  file("secret.xyz", "1 2 3\n");
  ASSERT_EQ(::chmod(at("secret.xyz").c_str(), 0), 0);
  // Root reads everything, so be nobody for a moment.
  const bool root = ::geteuid() == 0;
  if (root) {
    ASSERT_EQ(::seteuid(65534), 0);
  }
  const auto refused = collect({at("secret.xyz")});
  if (root) {
    ASSERT_EQ(::seteuid(0), 0);
  }
  // Nobody does not get through to root's folder, either.
  EXPECT_EQ(sentence(refused),
            at("secret.xyz") + (root ? ": cannot be examined" : ": cannot be opened") + ": Permission denied");
  EXPECT_EQ(refused.error().code, Errc::io);
}

TEST_F(CloudOfFiles, RefusesNonFinitePointsNamingFilePlaceAndCoordinate) {
  file("a.xyz", "1 2 3\n\n4 nan 6\n7 8 -inf\n");
  const auto refused = collect({at("a.xyz")});
  EXPECT_EQ(sentence(refused),
            at("a.xyz") + ", line 3: y is nan (skip-invalid=true drops such points and counts them)");
  EXPECT_EQ(refused.error().code, Errc::bad_input);
  const auto skipped = collect({at("a.xyz")}, {.skip_invalid = true});
  EXPECT_EQ(skipped.value().counts.invalid, 2u);
  EXPECT_EQ(skipped.value().counts.read, 3u);
  EXPECT_EQ(skipped.value().points, (std::vector<LocalPoint>{{{1, 2, 3}, 0}}));
  // In 2D the height of line 4 does not matter.
  EXPECT_EQ(collect({at("a.xyz")}, {.dimension = 2, .skip_invalid = true}).value().counts.invalid, 1u);
}

TEST_F(CloudOfFiles, HasNoNegativeZero) {
  file("a.xyz", "-0 -0.0 0\n1 -1e-400 -0\n");
  const auto all = collect({at("a.xyz")});
  ASSERT_EQ(all.value().points.size(), 2u);
  for (const auto& p : all.value().points)
    for (int axis = 0; axis < 3; ++axis) EXPECT_FALSE(std::signbit(p.at[axis]));
}

TEST_F(CloudOfFiles, CropsToAClosedBoxAndKeepsTheIdsOfTheRest) {
  file("a.xyz", "0 0 0\n1 1 1\n2 2 2\n3 3 3\n");
  Box crop;
  crop.lo.x = 1;
  crop.hi.z = 2;
  const auto all = collect({at("a.xyz")}, {.crop = crop});
  EXPECT_EQ(all.value().points, (std::vector<LocalPoint>{{{1, 1, 1}, 1}, {{2, 2, 2}, 2}}));
  EXPECT_EQ(all.value().counts.filtered, 2u);
  // In 2D a z bound still looks at the height of the file.
  EXPECT_EQ(collect({at("a.xyz")}, {.dimension = 2, .crop = crop}).value().points,
            (std::vector<LocalPoint>{{{1, 1, 0}, 1}, {{2, 2, 0}, 2}}));
}

TEST_F(CloudOfFiles, KeepsTheClassesAskedForWhetherOrNotTheClassIsCarried) {
  LasFile las;
  for (int i = 0; i < 100; ++i) las.points.push_back({i, 0, 0});  // record i is of class (i + 15) & 31
  folder_.write("a.las", las.bytes());
  for (const auto& carried : std::vector<std::vector<std::string>>{{}, {"classification"}, {"all"}}) {
    const auto all = collect({at("a.las")}, {.classes = {2, 9}, .attributes = carried});
    ASSERT_EQ(sentence(all), "");
    std::vector<std::uint64_t> ids;
    for (const auto& p : all.value().points) ids.push_back(p.id.value);
    EXPECT_EQ(ids, (std::vector<std::uint64_t>{19, 26, 51, 58, 83, 90}));
    EXPECT_EQ(all.value().counts.filtered, 94u);
  }
  file("b.xyz", "1 2 3\n");
  EXPECT_EQ(sentence(collect({at("a.las"), at("b.xyz")}, {.classes = {2}})),
            at("b.xyz") + ": has no attribute 'classification', so class cannot choose points by it");
}

TEST_F(CloudOfFiles, KeepsTheReturnsAskedForAndDropsFlaggedPoints) {
  LasFile las;
  for (int i = 0; i < 256; ++i) las.points.push_back({i, 0, 0});  // bytes 14 and 15 of record i: i + 14, i + 15
  folder_.write("a.las", las.bytes());
  const auto kept = [&](CloudOptions options, const std::function<bool(int number, int of, int flags)>& expected) {
    const auto all = collect({at("a.las")}, options);
    ASSERT_EQ(sentence(all), "");
    std::vector<std::uint64_t> ids, wanted;
    for (const auto& p : all.value().points) ids.push_back(p.id.value);
    for (int i = 0; i < 256; ++i)
      if (expected((i + 14) & 7, (i + 14) >> 3 & 7, (i + 15) >> 5 & 7)) wanted.push_back(static_cast<std::uint64_t>(i));
    EXPECT_EQ(ids, wanted);
    EXPECT_FALSE(wanted.empty());
    EXPECT_EQ(all.value().counts.filtered, 256 - wanted.size());
  };
  kept({.returns = Returns::first}, [](int number, int, int) { return number == 1; });
  kept({.returns = Returns::last, .attributes = {"return_number"}},
       [](int number, int of, int) { return number == of; });
  kept({.returns = Returns::single}, [](int, int of, int) { return of == 1; });
  kept({.without = {"withheld"}}, [](int, int, int flags) { return (flags & 4) == 0; });
  kept({.returns = Returns::first, .without = {"synthetic", "key_point"}, .attributes = {"all"}},
       [](int number, int, int flags) { return number == 1 && (flags & 3) == 0; });
  EXPECT_EQ(sentence(collect({at("a.las")}, {.without = {"overlap"}})),
            at("a.las") + ": has no attribute 'overlap', so without cannot choose points by it");
}

TEST_F(CloudOfFiles, KeepsTheScansAskedFor) {
  const std::string header = "1\n2\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";
  file("a.ptx", header + "1 0 0 1\n2 0 0 1\n" + header + "3 0 0 1\n0 0 0 1\n" + header + "4 0 0 1\n5 0 0 1\n");
  const auto ids = [&](std::vector<std::uint32_t> scans) {
    const auto all = collect({at("a.ptx")}, {.scans = std::move(scans)});
    EXPECT_EQ(sentence(all), "");
    std::vector<std::uint64_t> found;
    for (const auto& p : all.value().points) found.push_back(p.id.value);
    EXPECT_EQ(all.value().counts.filtered, 5 - found.size());
    return found;
  };
  EXPECT_EQ(ids({}), (std::vector<std::uint64_t>{0, 1, 2, 3, 4}));
  EXPECT_EQ(ids({1}), (std::vector<std::uint64_t>{2}));
  EXPECT_EQ(ids({2, 0, 9}), (std::vector<std::uint64_t>{0, 1, 3, 4}));
  EXPECT_EQ(ids({3}), (std::vector<std::uint64_t>{}));
  file("b.xyz", "1 2 3\n");
  EXPECT_EQ(sentence(collect({at("b.xyz")}, {.scans = {2}})),
            at("b.xyz") + ": has no attribute 'scan', so scan cannot choose points by it");
}

TEST_F(CloudOfFiles, TellsWhatWasFilteredOut) {
  LasFile las;
  for (int i = 0; i < 3; ++i) las.points.push_back({100 * i, 0, 700});  // of classes 15, 16 and 17
  folder_.write("a.las", las.bytes());
  const auto classes = collect({at("a.las")}, {.classes = {2}}).value().counts.other_classes;
  EXPECT_EQ(classes.to_ulong(), 7ul << 15);
  const auto outside = collect({at("a.las")}, {.crop = Box{{5, 5, 5}, {6, 6, 6}}}).value().counts.outside;
  EXPECT_EQ(outside, (Bounds{{0, 0, 7}, {2, 0, 7}}));
}

TEST_F(CloudOfFiles, RefusesDegreesBesideHeights) {
  file("a.csv", "lon,lat,height\n1,2,3\n4,5,6\n");
  const auto refused = sentence(collect({at("a.csv")}));
  EXPECT_NE(refused.find("a.csv: its header names longitude and latitude"), std::string::npos) << refused;
  EXPECT_EQ(sentence(collect({at("a.csv")}, {.dimension = 2})), "");
}

TEST_F(CloudOfFiles, CarriesAttributesOfSeveralFilesInOneSchema) {
  file("a.csv", "x,y,z,i\n1,2,3,7\n");
  LasFile las;
  las.points = {{1, 2, 3}};
  folder_.write("b.las", las.bytes());
  const auto cloud = Cloud::open({at("a.csv"), at("b.las")}, {.attributes = {"i", "intensity"}});
  ASSERT_EQ(sentence(cloud), "");
  EXPECT_EQ(cloud.value().schema(),
            (std::vector<Attribute>{{"i", AttributeType::f64}, {"intensity", AttributeType::u16}}));
  const auto all = collect(cloud.value());
  Bytes expected;
  push(expected, 7.0);
  push<std::uint16_t>(expected, 0);
  push(expected, 0.0);
  push<std::uint16_t>(expected, 12 | 13 << 8);
  EXPECT_EQ(all.value().rows, expected);
  EXPECT_EQ(sentence(Cloud::open({at("a.csv")}, {.attributes = {"j"}})),
            "no input file has an attribute 'j'; there are i");
}

TEST_F(CloudOfFiles, CarriesTheHeightAsAnAttributeIn2D) {
  file("a.xyz", "1 2 3\n4 5 6\n");
  file("flat.xyz", "1 2\n");
  const std::vector<Attribute> height{{"z", AttributeType::f64}};
  const auto schema = [&](const CloudOptions& options) { return Cloud::open({at("a.xyz")}, options).value().schema(); };
  EXPECT_EQ(schema({.dimension = 2, .attributes = {"all"}}), height);
  EXPECT_EQ(schema({.dimension = 2, .heights = false, .attributes = {"z"}}), height);
  EXPECT_TRUE(schema({.dimension = 2, .heights = false}).empty());
  EXPECT_TRUE(schema({.dimension = 3}).empty());
  EXPECT_TRUE(Cloud::open({at("flat.xyz")}, {.dimension = 2}).value().schema().empty());
  const auto cloud = Cloud::open({at("a.xyz")}, {.dimension = 2});
  ASSERT_EQ(cloud.value().schema(), height);
  const auto all = collect(cloud.value());
  Bytes heights;
  push(heights, 3.0);
  push(heights, 6.0);
  EXPECT_EQ(all.value().rows, heights);
  EXPECT_EQ(all.value().points[1].at, (Point{4, 5, 0}));
  EXPECT_TRUE(collect({at("a.xyz")}, {.attributes = {"z"}}).has_error()) << "in 3D it is a coordinate";
}

TEST_F(CloudOfFiles, RefusesAFileWithoutZForA3DCloud) {
  file("a.xyz", "1 2\n3 4\n");
  EXPECT_EQ(sentence(collect({at("a.xyz")})),
            at("a.xyz") + ": has only x and y, but a 3D triangulation needs z, too (see dim)");
  EXPECT_EQ(collect({at("a.xyz")}, {.dimension = 2}).value().points.size(), 2u);
}

TEST_F(CloudOfFiles, NoticesThatAFileChangesOrShrinks) {
  file("a.xyz", "1 2 3\n4 5 6\n");
  const auto cloud = Cloud::open({at("a.xyz")}, {});
  file("a.xyz", "1 2 3\n");
  EXPECT_EQ(sentence(collect(cloud.value())), at("a.xyz") + ": was changed by another program while it was read");

  LasFile las;
  for (int i = 0; i < 200000; ++i) las.points.push_back({i, 0, 0});
  folder_.write("b.las", las.bytes());
  const auto other = Cloud::open({at("b.las")}, {});
  const auto result = other.value().for_each_batch([&](CloudBatch&) -> Status {
    std::filesystem::resize_file(at("b.las"), 1000);
    return success();
  });
  EXPECT_EQ(sentence(result), at("b.las") + ": became shorter while it was read");
}

TEST_F(CloudOfFiles, StopsWhenTheVisitorDoes) {
  file("a.xyz", "1 2 3\n4 5 6\n");
  const auto cloud = Cloud::open({at("a.xyz")}, {});
  const auto stopped =
      cloud.value().for_each_batch([](CloudBatch&) -> Status { return error(Errc::interrupted, "stop"); });
  EXPECT_EQ(stopped.error().code, Errc::interrupted);
}

class SampleOfCloud : public CloudOfFiles {
 protected:
  // n points x = 0 .. n-1.
  void las(const std::string& name, int n) {
    LasFile file;
    file.scale = {1, 1, 1};
    for (int i = 0; i < n; ++i) file.points.push_back({i, i % 7, 0});
    folder_.write(name, file.bytes());
  }
  void text(const std::string& name, int n) {
    std::string lines;
    for (int i = 0; i < n; ++i) lines += std::to_string(i) + " " + std::to_string(i % 7) + " 1\n";
    file(name, lines);
  }
};

TEST_F(SampleOfCloud, IsEvenDeterministicAndOfAboutTheSizeAskedFor) {
  las("a.las", 300000);
  text("b.xyz", 100000);
  const auto cloud = Cloud::open({at("a.las"), at("b.xyz")}, {});
  const auto sample = sample_cloud(cloud.value(), 20000);
  ASSERT_EQ(sentence(sample), "");
  const auto again = sample_cloud(cloud.value(), 20000);
  EXPECT_EQ(sample.value(), again.value());
  EXPECT_GE(sample.value().size(), 10000u);
  EXPECT_LE(sample.value().size(), 40000u);
  std::size_t from_las = 0, first_half = 0;
  for (const auto& p : sample.value()) {
    if (p.z != 0) continue;
    ++from_las;
    first_half += p.x < 150000;
  }
  EXPECT_NEAR(static_cast<double>(from_las), 15000, 7500);
  EXPECT_NEAR(static_cast<double>(first_half) / static_cast<double>(from_las), 0.5, 0.05);
}

TEST_F(SampleOfCloud, OfMoreThanThereIsIsEverything) {
  las("a.las", 5000);
  const auto cloud = Cloud::open({at("a.las")}, {});
  const auto sample = sample_cloud(cloud.value(), 1000000);
  std::set<double> xs;
  for (const auto& p : sample.value()) xs.insert(p.x);
  EXPECT_EQ(xs.size(), 5000u);
  EXPECT_TRUE(sample_cloud(cloud.value(), 0).value().empty());
}

TEST_F(SampleOfCloud, FindsEnoughInASmallPartOfTheCloud) {
  las("a.las", 300000);
  Box crop;
  crop.lo.x = 100000;
  crop.hi.x = 102999;
  const auto cloud = Cloud::open({at("a.las")}, {.crop = crop});
  const auto sample = sample_cloud(cloud.value(), 2000);
  ASSERT_EQ(sentence(sample), "");
  EXPECT_GE(sample.value().size(), 1000u);
  for (const auto& p : sample.value()) EXPECT_TRUE(p.x >= 100000 && p.x <= 102999);
}

TEST_F(SampleOfCloud, OfNothingIsEmpty) {
  las("a.las", 0);
  EXPECT_TRUE(sample_cloud(Cloud::open({at("a.las")}, {}).value(), 100).value().empty());
  las("b.las", 100);
  Box nowhere;
  nowhere.lo.x = 1e9;
  EXPECT_TRUE(sample_cloud(Cloud::open({at("b.las")}, {.crop = nowhere}).value(), 100).value().empty());
}

}  // namespace
}  // namespace tessera::testing_io
