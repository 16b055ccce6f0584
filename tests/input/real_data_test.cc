// What readers make of real files that nobody on the project made.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <random>

#include "src/base/crs/crs.h"
#include "src/input/cloud/cloud.h"
#include "tests/input/laz_testing.h"
#include "tests/input/real_clouds.h"

namespace tessera::testing_io {
namespace {

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

nlohmann::json told_of(const std::string& name) {
  std::ifstream in(clouds / "manifest.json");
  return nlohmann::json::parse(in)[name];
}

class RealLas : public testing::TestWithParam<RealCloud> {};

TEST_P(RealLas, EveryPointStandsForItsIntegers) {
  const auto bytes = las_bytes(GetParam().path());
  const auto points_at = at<std::uint32_t>(bytes, 96);
  const auto record_bytes = at<std::uint16_t>(bytes, 105);
  const auto read = read_path(GetParam().path());
  ASSERT_EQ(sentence(read), "");
  ASSERT_EQ(read.value().points.size(), (bytes.size() - points_at) / record_bytes);
  for (std::size_t i = 0; i < read.value().points.size(); ++i)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto integer = at<std::int32_t>(bytes, points_at + i * record_bytes + 4 * axis);
      const double scale = at<double>(bytes, 131 + 8 * axis), offset = at<double>(bytes, 155 + 8 * axis);
      const double got = read.value().points[i][static_cast<int>(axis)];
      // Three roundings against one. Near 0, where offset and product cancel, an ulp of the result says nothing.
      const double slack = 2e-16 * (std::abs(integer * scale) + std::abs(offset));
      ASSERT_TRUE(ulps(got, integer * scale + offset) <= 1 || std::abs(got - (integer * scale + offset)) <= slack)
          << "record " << i << " axis " << axis;
      ASSERT_EQ(std::nearbyint((got - offset) / scale), integer) << "record " << i << " axis " << axis;
    }
}

INSTANTIATE_TEST_SUITE_P(
    Files, RealLas,
    testing::ValuesIn(
        real_clouds({"ign_77050_627755_begin.las", "autzen_trim.laz", "lone_star_begin.laz",
                     "lion_takanawa_part.copc.laz", "pdal_epsg_4326.las", "pdal_mvk_thin.las",
                     "pdal_hexbin_crop_begin.las", "liblas_certainty3d.las", "laspy_grid_begin.las",
                     "laz_perf/point-color.las", "laz_conformance/pdrf6-1.4.las", "laz_conformance/pdrf7-v4-1.4.las"},
                    {"ign_77050_627755.las", "ign_77050_627760.las", "ign_77055_627755.las", "ign_77055_627760.las",
                     "lidr_topography.las", "lidr_megaplot.las", "bcts_1.las", "pdal_hexbin_crop.las", "cgal_urban.las",
                     "lone_star.las", "lion_takanawa.copc.las", "treels_pine_plot.las", "laspy_grid.las"})));

// A file and a copy with other offsets, which is what its COPC twin is: the same points to the last bit.
class MovedLas : public testing::TestWithParam<RealCloud> {};

TEST_P(MovedLas, IsTheSameCloudWithAnotherOffset) {
  const auto original = las_bytes(GetParam().path());
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
  EXPECT_GT(naive_differences, expected.size() / 5) << "which is why";
}

INSTANTIATE_TEST_SUITE_P(Files, MovedLas, testing::ValuesIn(real_clouds({"lone_star_begin.laz"}, {"lone_star.las"})));

class LasAndDoubles : public testing::TestWithParam<RealCloud> {};

TEST_P(LasAndDoubles, AgreeToTheLastBitOrTheOneBeside) {
  const auto read = read_path(GetParam().path());
  const auto doubles = file_bytes(GetParam().path().replace_extension(".bin"));
  ASSERT_EQ(doubles.size(), read.value().points.size() * 24);
  for (std::size_t i = 0; i < read.value().points.size(); ++i)
    for (std::size_t axis = 0; axis < 3; ++axis)
      ASSERT_LE(ulps(read.value().points[i][static_cast<int>(axis)], at<double>(doubles, 24 * i + 8 * axis)), 1);
}

INSTANTIATE_TEST_SUITE_P(Files, LasAndDoubles,
                         testing::ValuesIn(real_clouds({"ign_77050_627755_begin.las"},
                                                       {"ign_77050_627755.las", "lidr_topography.las"})));

struct Located {
  RealCloud file;
  std::string crs_begins, title;  // "": not compared
  friend std::ostream& operator<<(std::ostream& out, const Located& located) { return out << located.file; }
};

std::vector<Located> located_files() {
  std::vector<Located> files{
      {{clouds, "ign_77050_627755.laz"}, "PROJCS[\"RGF93 v1 / Lambert-93\"", ""},
      {{clouds, "liblas_certainty3d.las"},
       "",
       "NAD83 / California zone 5 (ftUS) (EPSG:2229) + heights NAVD88 height (ftUS) (EPSG:6360)"},
      {{clouds, "pdal_mvk_thin.las"},  // EPSG:26995 would be metres
       "",
       "NAD83 / Mississippi West in US survey foot + heights NAVD88 height (ftUS) (EPSG:6360)"},
      {{clouds, "pdal_hexbin_crop_begin.las"}, "", "WGS 84 / UTM zone 42N (EPSG:32642)"},
      {{clouds, "pdal_epsg_4326.las"}, "EPSG:4326", ""},
      {{clouds, "lone_star_begin.laz"}, "GEOCCS", ""}};  // and not EPSG:4326, which its geographic key names
  if (!has_more_clouds()) return files;
  const std::vector<Located> more{
      {{more_clouds, "bcts_1.las"}, "", "NAD83 / BC Albers (EPSG:3005) + heights CGVD28 height (EPSG:5713)"},
      {{more_clouds, "lidr_megaplot.las"}, "", "NAD83 / UTM zone 17N (EPSG:26917) + heights unknown"},
      {{more_clouds, "lidr_topography.las"}, "EPSG:2949", ""}};
  files.insert(files.end(), more.begin(), more.end());
  return files;
}

class LocatedLas : public testing::TestWithParam<Located> {};

TEST_P(LocatedLas, CarriesItsCoordinateSystem) {
  const auto crs = open_reader(GetParam().file.path()).value()->info().crs;
  ASSERT_NE(crs, "");
  EXPECT_EQ(crs.substr(0, GetParam().crs_begins.size()), GetParam().crs_begins);
  EXPECT_EQ(GetParam().title.empty() ? "" : crs_title(crs), GetParam().title);
}

INSTANTIATE_TEST_SUITE_P(Files, LocatedLas, testing::ValuesIn(located_files()));

TEST(RealClouds, CarryTheirExtraBytesAndNoCoordinateSystemWhereThereIsNone) {
  const auto lion = open_reader(clouds / "lion_takanawa_part.copc.laz");
  EXPECT_EQ(lion.value()->info().crs, "");
  EXPECT_EQ(lion.value()->info().attributes.back().name, "OriginId");
  const std::vector<Attribute> schema{{"classification", AttributeType::u8}, {"OriginId", AttributeType::u32}};
  const auto read = read_path(clouds / "lion_takanawa_part.copc.laz", schema);
  EXPECT_EQ(read.value().rows.size(), 5 * read.value().points.size());
}

class PlyOrText : public testing::TestWithParam<RealCloud> {};

// As NumPy and Python read them.
TEST_P(PlyOrText, HasItsDoubles) {
  const auto told = told_of(GetParam().name);
  const auto read = read_path(GetParam().path());
  ASSERT_EQ(sentence(read), "");
  EXPECT_EQ(read.value().points.size(), told["points"].get<std::size_t>());
  Bytes doubles;
  for (const Point& p : read.value().points) push(doubles, p.x), push(doubles, p.y), push(doubles, p.z);
  EXPECT_EQ(sha256(doubles), told["xyz_sha256"].get<std::string>());
}

INSTANTIATE_TEST_SUITE_P(Files, PlyOrText,
                         testing::ValuesIn(real_clouds({"csf_sample_begin.ply", "isprs_CSite2_begin.ply",
                                                        "pdal_mesh.ply", "velodyne_400_begin.csv",
                                                        "velodyne_400_begin.xyz", "cities_begin.csv"},
                                                       {})));

struct Boxed {
  std::string name;
  std::size_t points = 0;
  Point lo, hi;
  friend std::ostream& operator<<(std::ostream& out, const Boxed& boxed) { return out << boxed.name; }
};

std::vector<Boxed> boxed_files() {
  if (!has_more_clouds()) return {};
  return {{"csf_sample.ply", 100000, {394554.875, 640383, 790.7399902}, {394790, 640627.5, 826.4470215}},
          {"isprs_CSite2.ply", 486800, {513449.6875, 5402650, 248.4100037}, {513870.3125, 5403283, 482.6300049}},
          {"bunny_zipper.ply", 35947, {-0.0946899, 0.0329874, -0.0618736}, {0.0610091, 0.187321, 0.0587997}},
          {"kitten.xyz", 5210, {-0.325311, -0.499731, -0.29561}, {0.325692, 0.4989, 0.294955}},
          {"sphere_20k.xyz", 21000, {-1.0949, -1.09454, -1.10493}, {1.07449, 1.08002, 1.11765}},
          {"velodyne_400.csv", 24989, {-59.5661, -59.5966, -10.719}, {67.1525, 71.0901, 29.2967}},
          {"cities.csv", 135233, {-179.12198, -77.846, 0}, {179.36451, 78.22334, 0}}};
}

class BoxedPlyOrText : public testing::TestWithParam<Boxed> {};

TEST_P(BoxedPlyOrText, HasItsCountAndBox) {
  const auto read = read_path(more_clouds / GetParam().name);
  ASSERT_EQ(sentence(read), "");
  EXPECT_EQ(read.value().points.size(), GetParam().points);
  Bounds box;
  for (const auto& p : read.value().points) box.add(p);
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(box.lo[axis], GetParam().lo[axis], 1e-7);
    EXPECT_NEAR(box.hi[axis], GetParam().hi[axis], 1e-7);
  }
}

INSTANTIATE_TEST_SUITE_P(Files, BoxedPlyOrText, testing::ValuesIn(boxed_files()));
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(BoxedPlyOrText);

class TextAndDoubles : public testing::TestWithParam<RealCloud> {};

TEST_P(TextAndDoubles, AreEqual) {
  const auto read = read_path(GetParam().path());
  const auto doubles = file_bytes(GetParam().path().replace_extension(".bin2"));
  ASSERT_EQ(doubles.size(), read.value().points.size() * 16);
  for (std::size_t i = 0; i < read.value().points.size(); ++i) {
    ASSERT_EQ(read.value().points[i].x, at<double>(doubles, 16 * i));
    ASSERT_EQ(read.value().points[i].y, at<double>(doubles, 16 * i + 8));
  }
}

INSTANTIATE_TEST_SUITE_P(Files, TextAndDoubles, testing::ValuesIn(real_clouds({"cities_begin.csv"}, {"cities.csv"})));

TEST(RealClouds, OfFourAdjacentTilesAreOneCloud) {
  const auto cloud = Cloud::open({(clouds / "ign_770*_6277*.laz").string()}, {.attributes = {"intensity", "gps_time"}});
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
