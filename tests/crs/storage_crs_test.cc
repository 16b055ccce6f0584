#include "src/base/crs/storage_crs.h"

#include <gtest/gtest.h>

namespace tessera {
namespace {

struct Case {
  const char *crs, *code;
  bool swapped;
};

TEST(StorageCrs, IsThatOfTheCodeWithTheOrderOfItsAxes) {
  for (const Case& one :
       {Case{"EPSG:2154", "2154", false}, Case{"EPSG:5698", "2154", false},  // the latter with heights
        Case{"EPSG:4326", "4326", true}, Case{"EPSG:31467", "31467", true}, Case{"EPSG:32631", "32631", false},
        Case{"EPSG:3035", "3035", true}}) {
    const auto found = storage_crs(one.crs);
    ASSERT_TRUE(found) << found.error().where;
    EXPECT_EQ(found.value().uri, std::string("http://www.opengis.net/def/crs/EPSG/0/") + one.code);
    EXPECT_EQ(found.value().swapped, one.swapped) << one.crs;
  }
}

TEST(StorageCrs, WithoutACodeHasNoName) {
  const auto none = storage_crs("LOCAL_CS[\"Undefined Cartesian SRS\"]");
  ASSERT_TRUE(none) << none.error().where;
  EXPECT_EQ(none.value().uri, "");
  EXPECT_FALSE(storage_crs("EPSG:999999"));
}

}  // namespace
}  // namespace tessera
