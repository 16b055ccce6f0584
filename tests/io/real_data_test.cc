// The real files that nobody on the project made. They are too many to copy: without them these tests are skipped.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>

#include "src/crs/crs.h"
#include "src/io/cloud/cloud.h"
#include "tests/io/las_file.h"
#include "tests/io/shared_data.h"

namespace tessera::testing_io {
namespace {

Bytes file_bytes(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  return bytes_of(text);
}

template <class T>
T at(const Bytes& bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

// Doubles between a and b, and one more if they differ.
std::int64_t ulps(double a, double b) {
  const auto ordered = [](double v) {
    const auto bits = std::bit_cast<std::int64_t>(v);
    return bits < 0 ? INT64_MIN - bits : bits;
  };
  return std::abs(ordered(a) - ordered(b));
}

// n of data/README.md.
const std::map<std::string, std::size_t> las_files{{"ign_77050_627755.las", 73355},
                                                   {"ign_77050_627760.las", 56035},
                                                   {"ign_77055_627755.las", 72770},
                                                   {"ign_77055_627760.las", 60653},
                                                   {"lidr_topography.las", 73403},
                                                   {"lidr_megaplot.las", 81590},
                                                   {"autzen_trim.las", 110000},
                                                   {"bcts_1.las", 531662},
                                                   {"pdal_epsg_4326.las", 5380},
                                                   {"pdal_mvk_thin.las", 6280},
                                                   {"pdal_hexbin_crop.las", 38367},
                                                   {"liblas_certainty3d.las", 10126},
                                                   {"cgal_urban.las", 13511},
                                                   {"lone_star.las", 518862},
                                                   {"lion_takanawa.copc.las", 341989},
                                                   {"treels_pine_plot.las", 114024},
                                                   {"laspy_grid.las", 22600},
                                                   {"laz_conformance/pdrf6-1.4.las", 1024},
                                                   {"laz_conformance/pdrf7-v4-1.4.las", 1024}};

TEST(RealLas, EveryPointStandsForItsIntegers) {
  REQUIRE_SHARED_DATA();
  for (const auto& [name, count] : las_files) {
    const auto read = read_path(data / name);
    ASSERT_EQ(sentence(read), "") << name;
    ASSERT_EQ(read.value().points.size(), count) << name;
    const auto bytes = file_bytes(data / name);
    const auto points_at = at<std::uint32_t>(bytes, 96);
    const auto record_bytes = at<std::uint16_t>(bytes, 105);
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto integer = at<std::int32_t>(bytes, points_at + i * record_bytes + 4 * axis);
        const double scale = at<double>(bytes, 131 + 8 * axis), offset = at<double>(bytes, 155 + 8 * axis);
        const double got = read.value().points[i][static_cast<int>(axis)];
        // Three roundings against one. Near 0, where offset and product cancel, an ulp of the result says nothing.
        const double slack = 2e-16 * (std::abs(integer * scale) + std::abs(offset));
        ASSERT_TRUE(ulps(got, integer * scale + offset) <= 1 || std::abs(got - (integer * scale + offset)) <= slack)
            << name << " record " << i << " axis " << axis;
        ASSERT_EQ(std::nearbyint((got - offset) / scale), integer) << name << " record " << i << " axis " << axis;
      }
  }
}

// lone_star.las and a copy with other offsets, which is what its COPC twin is: the same points to the last bit.
TEST(RealLas, IsTheSameCloudWithAnotherOffset) {
  REQUIRE_SHARED_DATA();
  const auto original = file_bytes(data / "lone_star.las");
  const auto expected = read_bytes(original, "a.las").value().points;
  std::size_t naive_differences = 0;
  for (const std::array<std::int32_t, 3> shift : {std::array{-2061584000, 0, -1}, {1000001, -77777, 9296000}}) {
    auto moved = original;
    const auto points_at = at<std::uint32_t>(moved, 96);
    const auto record_bytes = at<std::uint16_t>(moved, 105);
    bool fits = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      // shift steps of 0.00025 m, which are exact in the sixth decimal but not in binary.
      const double old_offset = at<double>(moved, 155 + 8 * axis);
      put(moved, 155 + 8 * axis, std::round((old_offset + shift[axis] * 0.00025) * 1e5) / 1e5);
      for (std::size_t i = 0; i < expected.size(); ++i) {
        const std::size_t place = points_at + i * record_bytes + 4 * axis;
        const auto integer = std::int64_t{at<std::int32_t>(moved, place)} - shift[axis];
        fits = fits && integer == static_cast<std::int32_t>(integer);
        put(moved, place, static_cast<std::int32_t>(integer));
        const double naive = static_cast<double>(integer) * 0.00025 + at<double>(moved, 155 + 8 * axis);
        naive_differences += naive != at<std::int32_t>(original, place) * 0.00025 + old_offset;
      }
    }
    ASSERT_TRUE(fits);
    EXPECT_EQ(read_bytes(moved, "a.las").value().points, expected);
  }
  EXPECT_GT(naive_differences, 100000u) << "which is why";
}

TEST(RealLas, AgreesWithTheDecodedDoublesToTheLastBitOrTheOneBeside) {
  REQUIRE_SHARED_DATA();
  for (const char* name : {"ign_77050_627755", "lidr_topography"}) {
    const auto read = read_path(data / (std::string(name) + ".las"));
    const auto doubles = file_bytes(data / (std::string(name) + ".bin"));
    ASSERT_EQ(doubles.size(), read.value().points.size() * 24);
    for (std::size_t i = 0; i < read.value().points.size(); ++i)
      for (std::size_t axis = 0; axis < 3; ++axis)
        ASSERT_LE(ulps(read.value().points[i][static_cast<int>(axis)], at<double>(doubles, 24 * i + 8 * axis)), 1);
  }
}

TEST(RealLas, CarriesItsCoordinateSystemAndAttributes) {
  REQUIRE_SHARED_DATA();
  const auto crs = [](const char* name) { return read_path(data / name).value().info.crs; };
  EXPECT_EQ(crs("ign_77050_627755.las").substr(0, 30), "PROJCS[\"RGF93 v1 / Lambert-93\"");
  EXPECT_EQ(crs_title(crs("bcts_1.las")), "NAD83 / BC Albers (EPSG:3005) + heights CGVD28 height (EPSG:5713)");
  EXPECT_EQ(crs_title(crs("lidr_megaplot.las")), "NAD83 / UTM zone 17N (EPSG:26917) + heights unknown");
  EXPECT_EQ(crs("lidr_topography.las"), "EPSG:2949");
  EXPECT_EQ(crs("pdal_epsg_4326.las"), "EPSG:4326");
  EXPECT_EQ(crs("lone_star.las").substr(0, 6), "GEOCCS") << "and not EPSG:4326, which its geographic key names";
  EXPECT_NE(crs("pdal_mvk_thin.las").find("US survey foot"), std::string::npos) << "EPSG:26995 would be metres";
  EXPECT_EQ(crs("treels_pine_plot.las"), "");
  const std::vector<Attribute> schema{{"classification", AttributeType::u8}, {"OriginId", AttributeType::u32}};
  const auto lion = open_reader(data / "lion_takanawa.copc.las");
  EXPECT_EQ(lion.value()->info().attributes.back().name, "OriginId") << "extra bytes";
}

TEST(RealPlyAndText, HaveTheirCountsAndBoxes) {
  REQUIRE_SHARED_DATA();
  struct Expected {
    const char* name;
    std::size_t points;
    Point lo, hi;
  };
  const std::vector<Expected> files{
      {"csf_sample.ply", 100000, {394554.875, 640383, 790.7399902}, {394790, 640627.5, 826.4470215}},
      {"isprs_CSite2.ply", 486800, {513449.6875, 5402650, 248.4100037}, {513870.3125, 5403283, 482.6300049}},
      {"bunny_zipper.ply", 35947, {-0.0946899, 0.0329874, -0.0618736}, {0.0610091, 0.187321, 0.0587997}},
      {"kitten.xyz", 5210, {-0.325311, -0.499731, -0.29561}, {0.325692, 0.4989, 0.294955}},
      {"sphere_20k.xyz", 21000, {-1.0949, -1.09454, -1.10493}, {1.07449, 1.08002, 1.11765}},
      {"velodyne_400.csv", 24989, {-59.5661, -59.5966, -10.719}, {67.1525, 71.0901, 29.2967}},
      {"cities.csv", 135233, {-179.12198, -77.846, 0}, {179.36451, 78.22334, 0}}};
  for (const auto& file : files) {
    const auto read = read_path(data / file.name);
    ASSERT_EQ(sentence(read), "");
    EXPECT_EQ(read.value().points.size(), file.points) << file.name;
    Bounds box;
    for (const auto& p : read.value().points) box.add(p);
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(box.lo[axis], file.lo[axis], 1e-7) << file.name;
      EXPECT_NEAR(box.hi[axis], file.hi[axis], 1e-7) << file.name;
    }
  }
}

TEST(RealPlyAndText, GiveTheDoublesOfTheirDecimals) {
  REQUIRE_SHARED_DATA();
  const auto read = read_path(data / "cities.csv");
  const auto doubles = file_bytes(data / "cities.bin2");
  ASSERT_EQ(doubles.size(), read.value().points.size() * 16);
  for (std::size_t i = 0; i < read.value().points.size(); ++i) {
    ASSERT_EQ(read.value().points[i].x, at<double>(doubles, 16 * i));
    ASSERT_EQ(read.value().points[i].y, at<double>(doubles, 16 * i + 8));
  }
}

TEST(RealCloud, OfFourAdjacentTilesIsOneCloud) {
  REQUIRE_SHARED_DATA();
  const auto cloud = Cloud::open({(data / "ign_770*_6277*.las").string()}, {.attributes = {"intensity", "gps_time"}});
  ASSERT_EQ(sentence(cloud), "");
  ASSERT_EQ(cloud.value().files().size(), 4u);
  std::uint64_t next = 0;
  const auto counts = cloud.value().for_each_batch([&](CloudBatch& batch) -> Status {
    for (const auto& p : batch.points) EXPECT_EQ(p.id.value, next++);
    EXPECT_EQ(batch.rows.size(), batch.points.size() * 10);
    return success();
  });
  EXPECT_EQ(counts.value().read, 73355u + 56035 + 72770 + 60653);
  EXPECT_EQ(cloud.value().crs().substr(0, 6), "PROJCS");
}

}  // namespace
}  // namespace tessera::testing_io
