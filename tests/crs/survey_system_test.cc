#include "src/base/crs/survey_system.h"

#include <gtest/gtest.h>

namespace tessera {
namespace {

TEST(CoordinateUnits, AreThoseOfTheSystemAndOfItsHeights) {
  const auto is = [](const char* crs, const char* horizontal, const char* vertical) {
    const CoordinateUnits units = coordinate_units(crs);
    EXPECT_EQ(units.horizontal, horizontal) << crs;
    EXPECT_EQ(units.vertical, vertical) << crs;
  };
  is("EPSG:2154", "metre", "metre");
  is("EPSG:5698", "metre", "metre");
  is("EPSG:2994", "foot", "foot");
  is("EPSG:2229", "US survey foot", "US survey foot");
  is("EPSG:6366", "metre", "metre");
  is("EPSG:4326", "degree", "");
  is("EPSG:4978", "metre", "metre");
  is("EPSG:8726", "US survey foot", "US survey foot");
  is(R"(COMPD_CS["c",LOCAL_CS["l",UNIT["kilometre",1000]],VERT_CS["h",VERT_DATUM["v",2005],UNIT["foot",0.3048]]])",
     "kilometre", "foot");
}

TEST(CoordinateUnits, NobodyKnowsAreEmpty) {
  for (const char* crs : {"", "EPSG:99999999", "PROJCS[", "mine"}) {
    EXPECT_EQ(coordinate_units(crs).horizontal, "") << crs;
    EXPECT_EQ(coordinate_units(crs).vertical, "") << crs;
  }
}

}  // namespace
}  // namespace tessera
