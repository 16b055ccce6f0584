#include "src/input/cloud/cloud_crs.h"

#include <gtest/gtest.h>

namespace tessera {
namespace {

FileInfo file(const char* name, const char* crs) {
  FileInfo info;
  info.path = name;
  info.crs = crs;
  return info;
}

std::string warnings(const CloudCrs& settled) {
  std::string all;
  for (const auto& warning : settled.warnings) all += warning + "\n";
  return all;
}

TEST(CloudCrs, FilesThatAgreeOrSayNothingHaveTheirSystem) {
  EXPECT_EQ(settle_crs({file("a", ""), file("b", "")}, "").value().crs, "");
  EXPECT_EQ(warnings(settle_crs({file("a", ""), file("b", "")}, "").value()), "");
  const auto settled = settle_crs({file("a", "EPSG:2154"), file("b", "EPSG:2154")}, "").value();
  EXPECT_EQ(settled.crs, "EPSG:2154");
  EXPECT_EQ(warnings(settled), "");
}

TEST(CloudCrs, TwoSystemsAreRefusedWithBothFilesAndSystems) {
  const auto settled =
      settle_crs({file("a.las", "EPSG:2154"), file("b.las", "EPSG:2154"), file("c.las", "EPSG:32740")}, "");
  ASSERT_FALSE(settled);
  EXPECT_EQ(settled.error().code, Errc::bad_input);
  for (const char* part : {"a.las", "c.las", "Lambert-93 (EPSG:2154)", "UTM zone 40S (EPSG:32740)"})
    EXPECT_NE(settled.error().where.find(part), std::string::npos) << part << " in " << settled.error().where;
}

TEST(CloudCrs, WhatIsGivenHoldsForAll) {
  const auto settled =
      settle_crs({file("a", "EPSG:2154"), file("b", "EPSG:32740"), file("c", "")}, "EPSG:3857").value();
  EXPECT_EQ(settled.crs, "EPSG:3857");
  EXPECT_EQ(warnings(settled), "");
}

TEST(CloudCrs, FilesWithoutASystemBesideFilesWithOneAreAWarning) {
  const auto settled = settle_crs({file("a.las", "EPSG:2154"), file("b.xyz", ""), file("c.xyz", "")}, "").value();
  EXPECT_EQ(settled.crs, "EPSG:2154");
  EXPECT_EQ(settled.warnings.size(), 1u);
  for (const char* part : {"2 of 3 files", "b.xyz", "a.las", "EPSG:2154"})
    EXPECT_NE(warnings(settled).find(part), std::string::npos) << part << " in " << warnings(settled);
}

TEST(CloudCrs, TheSystemWithHeightsIsTakenAndOthersThatLackThemAreAWarning) {
  const auto settled = settle_crs({file("a.las", "EPSG:2154"), file("b.las", "EPSG:5698")}, "").value();
  EXPECT_EQ(settled.crs, "EPSG:5698");
  EXPECT_NE(warnings(settled).find("a.las: says nothing of what its heights mean"), std::string::npos);
  EXPECT_FALSE(settle_crs({file("a", "EPSG:2154"), file("b", "EPSG:5698"), file("c", "EPSG:5699")}, "")) << "two seas";
}

TEST(CloudCrs, KeysThatAreNotUnderstoodAreAWarning) {
  auto vague = file("a.las", "");
  vague.crs_note = "its GeoTIFF keys are not understood: the keys name no coordinate system";
  EXPECT_EQ(warnings(settle_crs({vague}, "").value()), "a.las: " + vague.crs_note + "\n");
}

}  // namespace
}  // namespace tessera
