#include "src/base/crs/geotiff.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <vector>

#include "src/base/crs/crs.h"

namespace tessera {
namespace {

struct Key {
  std::uint16_t id, value, tag = 0, count = 1;
};

struct Keys {
  std::vector<Key> keys;
  std::vector<double> doubles = {};
  std::string ascii = {};
};

constexpr std::uint16_t model = 1024, citation = 1026, geographic = 2048, projected = 3072, linear_unit = 3076,
                        vertical = 4096, vertical_unit = 4099, user_defined = 32767;

Result<std::string> crs(const Keys& k) {
  std::vector<std::uint16_t> directory{1, 1, 0, static_cast<std::uint16_t>(k.keys.size())};
  for (const Key& key : k.keys) directory.insert(directory.end(), {key.id, key.tag, key.count, key.value});
  return crs_of({std::as_bytes(std::span(directory)), std::as_bytes(std::span(k.doubles)),
                 std::as_bytes(std::span(k.ascii.data(), k.ascii.size()))});
}

bool contains(const std::string& text, const char* part) { return text.find(part) != std::string::npos; }

TEST(GeoTiff, ACodeAloneIsThatCode) {
  EXPECT_EQ(crs({{{model, 1}, {projected, 2154}}}).value(), "EPSG:2154");
  EXPECT_EQ(crs({{{model, 1}, {projected, 2154}, {linear_unit, 9001}}}).value(), "EPSG:2154");
  EXPECT_EQ(crs({{{projected, 2949}}}).value(), "EPSG:2949") << "without a model";
  EXPECT_EQ(crs({{{model, 2}, {geographic, 4171}}}).value(), "EPSG:4171");
}

TEST(GeoTiff, ACodeInOtherUnitsIsNotThatCode) {
  const auto feet = crs({{{model, 1}, {projected, 26995}, {linear_unit, 9003}}}).value();
  EXPECT_TRUE(contains(feet, "US survey foot")) << feet;
  EXPECT_FALSE(contains(feet, "26995")) << feet;
  EXPECT_FALSE(same_crs(feet, "EPSG:26995"));
  EXPECT_EQ(crs_title(feet), "NAD83 / Mississippi West in US survey foot");
}

TEST(GeoTiff, HeightsAreKept) {
  const auto both = crs({{{model, 1}, {projected, 3005}, {vertical, 5713}, {vertical_unit, 9001}}}).value();
  EXPECT_EQ(crs_title(both), "NAD83 / BC Albers (EPSG:3005) + heights CGVD28 height (EPSG:5713)");
  const auto feet = crs({{{model, 1}, {projected, 26917}, {vertical_unit, 9003}}}).value();
  EXPECT_TRUE(has_heights(feet));
  EXPECT_TRUE(contains(feet, "VERT_CS[\"unknown\"")) << feet;
  EXPECT_TRUE(contains(feet, "US survey foot")) << feet;
}

TEST(GeoTiff, HeightsAreInTheUnitThatIsSaidWhateverTheirCode) {
  const auto feet = crs({{{model, 1}, {projected, 26917}, {vertical, 5703}, {vertical_unit, 9003}}}).value();
  EXPECT_EQ(crs_title(feet), "NAD83 / UTM zone 17N (EPSG:26917) + heights NAVD88 height in US survey foot");
  EXPECT_FALSE(contains(feet, "5703")) << feet;
  const auto metres = crs({{{model, 1}, {projected, 26917}, {vertical, 5703}, {vertical_unit, 9001}}}).value();
  EXPECT_TRUE(contains(metres, "5703")) << metres;
  EXPECT_FALSE(same_crs(feet, metres));
  EXPECT_EQ(crs({{{model, 1}, {projected, 26917}, {vertical, 5703}}}).value(), metres) << "by the code alone";
}

TEST(GeoTiff, GeocentricIsNotLongitudeAndLatitude) {
  const auto earth = crs({{{model, 3}, {geographic, 4326}}}).value();
  EXPECT_TRUE(contains(earth, "GEOCCS")) << earth;
  EXPECT_FALSE(same_crs(earth, "EPSG:4326"));
}

TEST(GeoTiff, AProjectionOfItsOwnIsReadFromItsParameters) {
  constexpr std::uint16_t doubles = 34736;
  const auto own = crs({{{model, 1},
                         {projected, user_defined},
                         {geographic, 4269},
                         {3074, user_defined},
                         {3075, 1},  // transverse Mercator
                         {linear_unit, 9001},
                         {3080, 0, doubles},   // meridian
                         {3081, 1, doubles},   // parallel
                         {3082, 2, doubles},   // false easting
                         {3083, 3, doubles},   // false northing
                         {3092, 4, doubles}},  // scale
                        {-71.25, 12, 1000, 2000, 0.9998}});
  ASSERT_TRUE(own) << own.error().where;
  for (const char* part : {"Transverse_Mercator", "-71.25", "0.9998", "1000", "2000", "NAD83"})
    EXPECT_TRUE(contains(own.value(), part)) << part << " in " << own.value();
}

TEST(GeoTiff, WhatNamesNoSystemIsAnError) {
  EXPECT_FALSE(crs({{{model, 1}, {projected, user_defined}}}));
  EXPECT_FALSE(crs({{{model, 1}, {projected, 65000}}}));
  EXPECT_FALSE(crs({{{model, 1}, {citation, 0, 34737, 5}}, {}, "none|"}));
  EXPECT_FALSE(crs({{}}));
  EXPECT_FALSE(crs_of({}));
}

TEST(GeoTiff, DirectoriesThatLieAreErrorsOrReadAsFarAsTheyGo) {
  std::vector<std::uint16_t> directory{1, 1, 0, 60000, model, 0, 1, 1, projected, 0, 1, 2154};
  static_cast<void>(crs_of({std::as_bytes(std::span(directory)), {}, {}}));
  EXPECT_FALSE(crs_of({std::as_bytes(std::span(directory)).first(7), {}, {}}));
  directory = {1, 1, 0, 1, 3080, 34736, 1, 9};  // a double where there is none
  static_cast<void>(crs_of({std::as_bytes(std::span(directory)), {}, {}}));
  for (unsigned seed = 0; seed < 300; ++seed) {
    std::vector<std::uint16_t> noise{1, 1, 0, static_cast<std::uint16_t>(seed % 7)};
    for (unsigned i = 0; i < 4 * (seed % 9); ++i)
      noise.push_back(static_cast<std::uint16_t>((seed * 2654435761u + i * 40503u) >> (i % 13)));
    static_cast<void>(crs_of({std::as_bytes(std::span(noise)), {}, {}}));
  }
}

}  // namespace
}  // namespace tessera
