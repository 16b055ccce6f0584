#include "src/delaunay/update/select_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "src/geometry/reference/clouds.h"
#include "src/result/tile_source.h"
#include "src/result/voronoi/clip_region.h"
#include "tests/store/sample_result.h"
#include "tests/update/stored_cloud.h"

namespace tessera::testing {
namespace {

namespace fs = std::filesystem;

// Of a cloud with a class for each point.
class Selection : public ::testing::Test {
 protected:
  Selection() {
    cloud_.dimension = 2;
    std::uint64_t id = 0;
    Bounds bounds;
    for (const LocalPoint& p : make_cloud("uniform", 2, 300, 1)) {
      cloud_.points.push_back({p.at, PointId{id++}});
      bounds.add(p.at);
      places_.push_back(p.at);
    }
    cloud_.points.push_back({places_[7], PointId{id++}});  // a duplicate
    cloud_.points_read = id;
    cloud_.partition = Partition::build_tiles(PartitionKind::kdtree, 2, places_, bounds, 9);
    cloud_.schema = {
        {"some", AttributeType::u8}, {"classification", AttributeType::u8}, {"gps_time", AttributeType::f64}};
    cloud_.row_of = [](PointId point) {
      std::vector<std::byte> row{std::byte{9}, static_cast<std::byte>(point.value % 5)};
      const double time = time_of(point);
      row.resize(2 + sizeof time);
      std::memcpy(&row[2], &time, sizeof time);
      return row;
    };
    cloud_.store(folder_.path() / "r");
  }
  std::vector<PointId> select(const PointSelection& selection) const {
    const auto source = TileSource::open(folder_.path() / "r").value();
    auto selected = select_points(source, selection, 2, {});
    EXPECT_TRUE(selected) << (selected ? "" : selected.error().where);
    return selected ? selected.value() : std::vector<PointId>{};
  }
  static double time_of(PointId point) {
    return point.value % 13 == 7 ? std::numeric_limits<double>::quiet_NaN() : static_cast<double>(point.value % 13);
  }
  // Those for which `wanted` holds.
  template <class Wanted>
  std::vector<PointId> points_with(const Wanted& wanted) const {
    std::vector<PointId> ids;
    for (const LocalPoint& p : cloud_.points) {
      if (wanted(p)) ids.push_back(p.id);
    }
    return ids;
  }

  StoredCloud cloud_;
  std::vector<Point> places_;
  const test::TemporaryFolder folder_;
};

TEST_F(Selection, HasThePointsOfTimesInputsPlacesAndPolygons) {
  EXPECT_EQ(select({.times = PointSelection::Times{3, 5}}),
            points_with([](const LocalPoint& p) { return time_of(p.id) >= 3 && time_of(p.id) <= 5; }));
  EXPECT_EQ(
      select({.inputs = {{10, 20}, {290, std::numeric_limits<std::uint64_t>::max()}}}),
      points_with([](const LocalPoint& p) { return (p.id.value >= 10 && p.id.value < 30) || p.id.value >= 290; }));
  EXPECT_EQ(select({.places = {places_[7], {7, 7, 0}, places_[40]}}),
            points_with([&](const LocalPoint& p) { return p.at == places_[7] || p.at == places_[40]; }));
  // a polygon with one of the points as a corner, and one far away
  const std::vector<std::vector<Point>> ring{{{0, 0, 0}, {1, 0, 0}, places_[9]}},
      far{{{8, 8, 0}, {9, 8, 0}, {8, 9, 0}}};
  voronoi::ClipRegion region;
  region.add(ring);
  region.add(far);
  region.index();
  const Point& top = places_[9];
  const auto inside = points_with([&](const LocalPoint& p) {
    const Point& q = p.at;
    return top.x * q.y - top.y * q.x <= 0 && (1 - top.x) * q.y + top.y * (q.x - 1) <= 0;
  });
  EXPECT_TRUE(std::find(inside.begin(), inside.end(), PointId{9}) != inside.end());
  EXPECT_EQ(select({.regions = {std::make_shared<const voronoi::ClipRegion>(region)}}), inside);
}

// A result of older software has no attributes of duplicates: they count as their vertices.
TEST_F(Selection, OfAClassTakesDuplicatesWithTheirVerticesWhereNothingElseIsKnown) {
  cloud_.duplicate_rows = false;
  fs::remove_all(folder_.path() / "r");
  cloud_.store(folder_.path() / "r");
  EXPECT_EQ(select({.classes = {2}}),
            points_with([&](const LocalPoint& p) { return (p.id.value == places_.size() ? 7 : p.id.value) % 5 == 2; }));
}

TEST_F(Selection, OfAnInputIsFoundByItsPathAndToldWhenItIsNotClear) {
  Manifest manifest;
  using Ids = Manifest::Input::Ids;
  manifest.inputs = {
      {"/a/one.las", 1, 1, Ids{0, 10}}, {"/a/two.las", 1, 1, Ids{10, 5}}, {"/a/one.las", 1, 1, Ids{15, 7}}};
  const auto asked = [&](const std::string& file) { return ids_of_input("r", manifest, file); };
  EXPECT_EQ(asked("/a/two.las").value(), (Ids{10, 5}));
  EXPECT_EQ(asked("/a/b/../two.las").value(), (Ids{10, 5}));
  EXPECT_EQ(asked("/a/one.las@15").value(), (Ids{15, 7}));
  EXPECT_EQ(
      asked("/a/one.las").error().where,
      "r: '/a/one.las' was read 2 times (points 0 to 9, points 15 to 21); name one of them by its first point, for "
      "example '/a/one.las@15'");
  EXPECT_EQ(asked("/a/one.las@16").error().where,
            "r: no points came from '/a/one.las@16'; the inputs are /a/one.las, /a/two.las, /a/one.las");
  manifest.inputs[1].ids.reset();
  EXPECT_NE(asked("/a/two.las").error().where.find("older software wrote it"), std::string::npos);
}

TEST_F(Selection, HasThePointsOfABoxOrAClass) {
  const Box box{{0.2, 0.1, -1}, {0.4, 0.9, 1}};
  std::vector<PointId> in_box, of_class;
  for (const LocalPoint& p : cloud_.points) {
    if (box.lo.x <= p.at.x && p.at.x <= box.hi.x && box.lo.y <= p.at.y && p.at.y <= box.hi.y) in_box.push_back(p.id);
    if (p.id.value % 5 == 2) of_class.push_back(p.id);
  }
  EXPECT_EQ(select({.box = box}), in_box);
  EXPECT_EQ(select({.classes = {2}}), of_class);
  std::vector<PointId> both;
  std::set_union(in_box.begin(), in_box.end(), of_class.begin(), of_class.end(), std::back_inserter(both));
  EXPECT_EQ(select({.box = box, .classes = {2}}), both);
  EXPECT_TRUE(select({.classes = {200}}).empty());
  EXPECT_TRUE(select({}).empty());
}

}  // namespace
}  // namespace tessera::testing
