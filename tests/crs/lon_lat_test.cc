#include "src/base/crs/lon_lat.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace tessera {
namespace {

TEST(LonLat, KnowsWherePlacesAreAndBack) {
  for (const char* crs : {"EPSG:2154", "EPSG:5698"}) {  // the latter with heights
    const auto places = LonLat::of(crs);
    ASSERT_TRUE(places) << places.error().where;
    std::vector<Point> points{{700000, 6600000, 7}, {652469.02, 6862035.26, 8}};
    const auto before = points;
    ASSERT_TRUE(places.value().to(points));
    EXPECT_NEAR(points[0].x, 3, 1e-9) << "where Lambert-93 begins";
    EXPECT_NEAR(points[0].y, 46.5, 1e-9);
    EXPECT_NEAR(points[1].x, 2.3522, 2e-4) << "Paris";
    EXPECT_NEAR(points[1].y, 48.8566, 2e-4);
    EXPECT_EQ(points[1].z, 8);
    ASSERT_TRUE(places.value().from(points));
    for (std::size_t i = 0; i < points.size(); ++i) {
      EXPECT_NEAR(points[i].x, before[i].x, 1e-6);
      EXPECT_NEAR(points[i].y, before[i].y, 1e-6);
    }
  }
}

TEST(LonLat, ABoxHoldsAllPlacesOfTheOther) {
  const auto places = LonLat::of("EPSG:2154");
  ASSERT_TRUE(places) << places.error().where;
  const Bounds box{{300000, 6200000, 0}, {1100000, 7000000, 0}};
  const auto around = places.value().box_to(box);
  ASSERT_TRUE(around) << around.error().where;
  std::vector<Point> points;
  for (int i = 0; i <= 777; ++i)
    for (const double y : {box.lo.y, box.hi.y}) points.push_back({box.lo.x + i * (box.hi.x - box.lo.x) / 777, y, 0});
  ASSERT_TRUE(places.value().to(points));
  for (const Point& p : points) {
    EXPECT_LE(around.value().lo.x, p.x);
    EXPECT_LE(around.value().lo.y, p.y);
    EXPECT_GE(around.value().hi.x, p.x);
    EXPECT_GE(around.value().hi.y, p.y);
  }
}

TEST(LonLat, WhatIsNowhereIsRefused) {
  for (const char* crs : {"", "LOCAL_CS[\"Undefined Cartesian SRS\"]", "EPSG:4978", "EPSG:999999", "nonsense"})
    EXPECT_FALSE(LonLat::of(crs)) << crs;
  const auto places = LonLat::of("EPSG:2154");
  ASSERT_TRUE(places) << places.error().where;
  std::vector<Point> beyond_the_pole{{3, 100, 0}}, endless{{std::numeric_limits<double>::infinity(), 0, 0}};
  EXPECT_FALSE(places.value().from(beyond_the_pole));
  EXPECT_FALSE(places.value().to(endless));
}

}  // namespace
}  // namespace tessera
