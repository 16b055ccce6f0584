// Regions of files: COPC, several files as one cloud, files without bounds, and files that state wrong ones.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "src/geometry/predicates/exact/predicates.h"
#include "src/geometry/reference/reference.h"
#include "src/input/bytes/fields.h"
#include "src/input/cloud/cloud_units.h"
#include "src/result/region/meets.h"
#include "src/result/region/regions.h"
#include "tests/input/real_clouds.h"
#include "tests/region/copc_file.h"

namespace tessera {
namespace {

using testing_io::sentence;
using testing_io::TempFolder;
using testing_region::CopcFile;

// A made-up block: hills in steps of a centimetre, a corner of which is a lattice. `from`: where x begins, in steps.
CopcFile block(std::int32_t from, std::size_t points, std::uint64_t seed) {
  CopcFile file;
  file.offset = {700000, 6600000, 0};
  file.cells = 8;
  file.few = 20;
  std::mt19937_64 random(seed);
  for (std::size_t i = 0; i < points; ++i) {
    const auto x = static_cast<std::int32_t>(random() % 4000), y = static_cast<std::int32_t>(random() % 4000);
    const auto z = static_cast<std::int32_t>(100 * std::sin(x * 0.002) * std::cos(y * 0.003)) + 500;
    if (x < 1000 && y < 1000) {
      file.points.push_back({from + x / 100 * 100, y / 100 * 100, 400});
    } else {
      file.points.push_back({from + x, y, z});
    }
  }
  return file;
}

struct Asked {
  Regions regions;
  int dimension;
};

Result<Asked> ask_of(const std::vector<std::string>& files, int dimension, bool scan) {
  BOOST_OUTCOME_TRY(cloud, Cloud::open(files, {.dimension = dimension, .heights = false}));
  BOOST_OUTCOME_TRY(units, CloudUnits::open(std::move(cloud), scan));
  return Asked{Regions(std::move(units), dimension, 0), dimension};
}

std::vector<LocalPoint> all_points(const std::vector<std::string>& files, int dimension) {
  std::vector<LocalPoint> points;
  const auto cloud = Cloud::open(files, {.dimension = dimension, .heights = false});
  EXPECT_EQ(sentence(cloud), "");
  EXPECT_EQ(sentence(cloud.value().for_each_batch([&](CloudBatch& batch) -> Status {
              points.insert(points.end(), batch.points.begin(), batch.points.end());
              return success();
            })),
            "");
  return points;
}

std::vector<IdCell> meeting(const std::vector<IdCell>& cells, const std::map<PointId, Point>& at, const Bounds& box,
                            int dimension) {
  std::vector<IdCell> met;
  const auto corners = static_cast<std::size_t>(dimension) + 1;
  for (const IdCell& cell : cells) {
    std::array<Point, 4> p{};
    for (std::size_t i = 0; i < corners; ++i) p[i] = at.at(cell[i]);
    const int side =
        dimension == 3 ? exact::orientation_3(p[0], p[1], p[2], p[3]) : exact::orientation_2(p[0], p[1], p[2]);
    if (side < 0) std::swap(p[0], p[1]);
    if (meets(std::span(p).first(corners), box)) met.push_back(cell);
  }
  return met;
}

// Asks for random boxes between points, and compares with CGAL's triangulation of all points. Whether anything stayed
// unread.
bool check_regions(const std::vector<std::string>& files, int dimension, bool scan, int regions, double size) {
  const auto points = all_points(files, dimension);
  const auto cells = global_delaunay(points, dimension);
  std::map<PointId, Point> at;
  for (const auto& p : points) at[p.id] = p.at;
  auto asked = ask_of(files, dimension, scan);
  EXPECT_EQ(sentence(asked), "");
  std::mt19937_64 random(7);
  bool unread = false;
  for (int i = 0; i < regions; ++i) {
    const Point a = points[random() % points.size()].at, b = points[random() % points.size()].at;
    Bounds box;
    box.add(a);
    box.add(Point{a.x + (b.x - a.x) * size, a.y + (b.y - a.y) * size, a.z + (b.z - a.z) * size});
    const Box region{box.lo, box.hi};
    if (i % 2 == 0) asked.value().regions.forget();
    const auto answer = asked.value().regions.ask(region, {});
    EXPECT_EQ(sentence(answer), "");
    if (answer.has_error()) return false;
    EXPECT_EQ(difference(meeting(cells, at, box, dimension), main_cells(std::span(&answer.value().mesh, 1))), "")
        << files[0] << ", region " << i;
    unread |= answer.value().figures.units_used < answer.value().figures.units;
  }
  return unread;
}

class FileRegions : public testing::TestWithParam<int> {};

TEST_P(FileRegions, OfTwoCopcFilesThatShareABorderAreThoseOfTheWhole) {
  const TempFolder folder;
  CopcFile left = block(0, 6000, 1), right = block(4000, 6000, 2);
  // Points of one in the other: the lowest source index stays.
  right.points.insert(right.points.end(), left.points.begin(), left.points.begin() + 300);
  const std::vector<std::string> files{folder.write("a.copc.laz", left.bytes()).string(),
                                       folder.write("b.copc.laz", right.bytes()).string()};
  EXPECT_TRUE(check_regions(files, GetParam(), false, 24, 0.15));
  EXPECT_TRUE(check_regions(files, GetParam(), true, 8, 0.15)) << "of bounds that were seen";
}

TEST_P(FileRegions, OfFilesThatDoNotTellTheirBounds) {
  const TempFolder folder;
  std::mt19937_64 random(3);
  std::vector<std::string> files;
  for (int f = 0; f < 6; ++f) {
    std::string text;
    for (int i = 0; i < 200; ++i) {
      text += std::to_string(f * 10 + static_cast<double>(random() % 1000) / 100) + " " +
              std::to_string(random() % 10) + " " + std::to_string(random() % 10) + "\n";
    }
    files.push_back(folder.write("p" + std::to_string(f) + ".xyz", text).string());
  }
  EXPECT_TRUE(check_regions(files, GetParam(), false, 20, 0.1));
}

TEST_P(FileRegions, OfRealCopcFiles) {
  check_regions({(testing_io::clouds / "ellipsoid.copc.laz").string()}, GetParam(), false, 8, 0.05);
}

TEST_P(FileRegions, OfRealFilesOfABlock) {
  std::vector<std::string> files;
  for (const char* name :
       {"ign_77050_627755.laz", "ign_77050_627760.laz", "ign_77055_627755.laz", "ign_77055_627760.laz"})
    files.push_back((testing_io::clouds / name).string());
  check_regions(files, GetParam(), false, 6, 0.1);
}

INSTANTIATE_TEST_SUITE_P(Dimensions, FileRegions, testing::Values(2, 3));

// A file states a box that is smaller than its points': refused when a point outside of it is met, and handled when the
// files are read first.
TEST(FileRegion, RefusesAPointThatIsNotWhereTheFileSays) {
  const TempFolder folder;
  auto bytes = block(0, 4000, 1).bytes();
  testing_io::put(bytes, 179, 700020.0);  // the greatest x of the header
  const std::vector<std::string> files{folder.write("wrong.copc.laz", bytes).string()};
  auto asked = ask_of(files, 2, false);
  ASSERT_EQ(sentence(asked), "");
  const Box region{{700018, 6600018}, {700019, 6600019}};
  const auto answer = asked.value().regions.ask(region, {});
  ASSERT_TRUE(answer.has_error());
  EXPECT_EQ(answer.error().code, Errc::bad_input);
  EXPECT_NE(sentence(answer).find("wrong.copc.laz, record "), std::string::npos) << sentence(answer);
  EXPECT_NE(sentence(answer).find("lies outside the box that the file states for it"), std::string::npos);
  EXPECT_TRUE(check_regions(files, 2, true, 8, 0.1));
}

TEST(FileRegion, RefusesAHierarchyThatLeavesAChunkOut) {
  const TempFolder folder;
  auto bytes = block(0, 4000, 1).bytes();
  const auto hierarchy_bytes = load<std::uint64_t>(bytes.data() + 375 + 54 + 48);
  testing_io::put(bytes, 375 + 54 + 48, hierarchy_bytes - 32);
  const auto asked = ask_of({folder.write("short.copc.laz", bytes).string()}, 2, false);
  ASSERT_TRUE(asked.has_error());
  EXPECT_NE(sentence(asked).find("leaves out 1 of the"), std::string::npos) << sentence(asked);
}

TEST(FileRegion, OfAFileReadsAFractionOfIt) {
  const TempFolder folder;
  const std::vector<std::string> files{folder.write("a.copc.laz", block(0, 60000, 1).bytes()).string()};
  auto asked = ask_of(files, 2, false);
  ASSERT_EQ(sentence(asked), "");
  const auto answer = asked.value().regions.ask({{700020, 6600020}, {700024, 6600024}}, {});
  ASSERT_EQ(sentence(answer), "");
  EXPECT_LT(answer.value().figures.bytes_read, answer.value().figures.bytes / 10);
  EXPECT_LT(answer.value().figures.points_read, 6000u);
}

}  // namespace
}  // namespace tessera
