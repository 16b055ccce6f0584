#include "src/base/crs/crs.h"

#include <gtest/gtest.h>

namespace tessera {
namespace {

TEST(Crs, OnlyWktAndCodesReachGdalWhichWouldOpenFilesAndAddresses) {
  for (const char* text : {"EPSG:2154", "PROJCS[\"x\"]", "GEOGCS(\"x\")", " BOUNDCRS\n[x]"})
    EXPECT_TRUE(looks_like_crs(text)) << text;
  for (const char* text : {"", "EPSG:", "EPSG:2154 ", "EPSG:-1", "EPSG:99999999999", "http://127.0.0.1/[",
                           "/etc/passwd", "./PROJCS[", "../x(", "[", "WGS84", "a[ +init=/etc/passwd:x", "a[\"x\"]"})
    EXPECT_FALSE(looks_like_crs(text)) << text;
  EXPECT_EQ(crs_or_none("EPSG:2154"), "EPSG:2154");
  EXPECT_EQ(crs_or_none("/etc/passwd"), "");
}

TEST(Crs, NamesOfGeoJsonBecomeCodes) {
  for (const char* name : {"EPSG:2154", "urn:ogc:def:crs:EPSG::2154", "urn:ogc:def:crs:EPSG:9.8.6:2154",
                           "http://www.opengis.net/def/crs/EPSG/0/2154"})
    EXPECT_EQ(crs_of_name(name), "EPSG:2154") << name;
  for (const char* name : {"urn:ogc:def:crs:OGC:1.3:CRS84", "http://www.opengis.net/def/crs/OGC/1.3/CRS84"})
    EXPECT_EQ(crs_of_name(name), "EPSG:4326") << name;
  for (const char* name : {"", "mine", "urn:ogc:def:crs:EPSG::", "/etc/EPSG"}) EXPECT_EQ(crs_of_name(name), name);
  EXPECT_EQ(crs_code("EPSG:2154"), "EPSG:2154");
  EXPECT_EQ(crs_code("EPSG:5698"), "EPSG:2154") << "without its heights";
  EXPECT_EQ(crs_code(""), "");
}

TEST(Crs, OtherSystemsAreThoseThatAreUnderstood) {
  EXPECT_TRUE(surely_other_crs("EPSG:2154", "EPSG:4326"));
  EXPECT_FALSE(surely_other_crs("EPSG:2154", "EPSG:5698")) << "one has heights";
  for (const char* unknown : {"", "EPSG:99999999", "PROJCS[\"x\"]", "mine"})
    EXPECT_FALSE(surely_other_crs("EPSG:2154", unknown)) << unknown;
}

TEST(Crs, TheHorizontalSystemIsNamedByItsCodeOrElseWrittenOut) {
  EXPECT_EQ(crs_name_or_wkt("EPSG:2154").value(), "urn:ogc:def:crs:EPSG::2154");
  EXPECT_EQ(crs_name_or_wkt("EPSG:5698").value(), "urn:ogc:def:crs:EPSG::2154") << "Lambert-93 with heights";
  EXPECT_EQ(crs_name_or_wkt("").value(), undefined_crs);
  const std::string own =
      R"(PROJCS["mine",GEOGCS["g",DATUM["d",SPHEROID["s",6378137,298.2]],PRIMEM["Greenwich",0],)"
      R"(UNIT["degree",0.0174532925199433]],PROJECTION["Transverse_Mercator"],PARAMETER["latitude_of_origin",12],)"
      R"(PARAMETER["central_meridian",3],PARAMETER["scale_factor",0.99],PARAMETER["false_easting",5000],)"
      R"(PARAMETER["false_northing",10],UNIT["metre",1]])";
  EXPECT_TRUE(crs_name_or_wkt(own).value().starts_with("PROJCS[\"mine\""));
  const std::string compound = "COMPD_CS[\"c\"," + own + R"(,VERT_CS["h",VERT_DATUM["v",2005],UNIT["metre",1]]])";
  EXPECT_TRUE(crs_name_or_wkt(compound).value().starts_with("PROJCS[\"mine\""));
}

const std::string lambert_93 =
    R"(PROJCS["RGF93_Lambert_93",GEOGCS["GCS_RGF_1993",DATUM["D_RGF_1993",SPHEROID["GRS_1980",6378137,298.257222101]],)"
    R"(PRIMEM["Greenwich",0],UNIT["Degree",0.017453292519943295]],PROJECTION["Lambert_Conformal_Conic"],)"
    R"(PARAMETER["False_Easting",700000],PARAMETER["False_Northing",6600000],PARAMETER["Central_Meridian",3],)"
    R"(PARAMETER["Standard_Parallel_1",49],PARAMETER["Standard_Parallel_2",44],PARAMETER["Latitude_Of_Origin",46.5],)"
    R"(UNIT["Meter",1]])";

TEST(Crs, TwoTextsOfOneSystemAreTheSame) {
  EXPECT_TRUE(same_crs("EPSG:2154", "EPSG:2154"));
  EXPECT_TRUE(same_crs("EPSG:2154", lambert_93)) << "as another program spells it";
  EXPECT_TRUE(same_crs("EPSG:2154", "EPSG:5698")) << "the latter says what heights mean, too";
  EXPECT_TRUE(same_crs("no system", "no system"));
}

TEST(Crs, OtherZonesUnitsHeightsAndTextsThatNobodyUnderstandsAreOthers) {
  EXPECT_FALSE(same_crs("EPSG:2154", "EPSG:32740"));
  EXPECT_FALSE(same_crs("EPSG:32631", "EPSG:32632"));
  EXPECT_FALSE(same_crs("EPSG:26995", "EPSG:3815")) << "metres and feet";
  EXPECT_FALSE(same_crs("EPSG:5698", "EPSG:5699")) << "heights above other seas";
  EXPECT_FALSE(same_crs("EPSG:4979", "EPSG:4978")) << "geographic and geocentric";
  EXPECT_FALSE(same_crs("EPSG:2154", "PROJCS[nonsense"));
  EXPECT_FALSE(same_crs("PROJCS[nonsense", "PROJCS[other nonsense"));
}

TEST(Crs, TitlesNameSystemsByNameAndCode) {
  EXPECT_EQ(crs_title("EPSG:2154"), "RGF93 v1 / Lambert-93 (EPSG:2154)");
  EXPECT_NE(crs_title(lambert_93).find("(EPSG:2154)"), std::string::npos);
  EXPECT_EQ(crs_title("EPSG:5698"), "RGF93 v1 / Lambert-93 (EPSG:2154) + heights NGF-IGN69 height (EPSG:5720)");
  EXPECT_EQ(crs_title("PROJCS[\"mine\",nonsense"), "mine");
  EXPECT_EQ(crs_title("whatever"), "whatever");
  EXPECT_NE(crs_title("EPSG:4978").find("geocentric"), std::string::npos);
}

TEST(Crs, OnlyWhatIsUnderstoodIsTakenFromAUser) {
  EXPECT_TRUE(check_crs("EPSG:2154"));
  EXPECT_TRUE(check_crs(lambert_93));
  for (const char* text : {"EPSG:99999", "PROJCS[nonsense", "WGS84", ""}) EXPECT_FALSE(check_crs(text)) << text;
}

TEST(Crs, SomeSayWhatHeightsMean) {
  EXPECT_TRUE(has_heights("EPSG:5698"));
  EXPECT_FALSE(has_heights("EPSG:2154"));
  EXPECT_FALSE(has_heights(""));
}

}  // namespace
}  // namespace tessera
