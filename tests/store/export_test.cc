// What the formats hold is read back by VTK in read_result.py; here are refusals and names.
#include "src/store/export.h"

#include <gtest/gtest.h>

#include <fstream>

#include "src/store/export_common.h"
#include "tests/store/sample_result.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using test::sample_points;
using test::sample_tiles;
using test::Shape;
using test::store_sample;
using test::TemporaryFolder;

TEST(Export, GeoJsonRefusesTetrahedraInOneSentence) {
  const TemporaryFolder folder;
  store_sample(folder.path(), sample_tiles(sample_points(Shape::uniform, 3, 50), 3, 1));
  const auto result = export_result(folder.path(), ExportFormat::geojson, folder.path() / "a.geojson", {});
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, Errc::usage);
  EXPECT_FALSE(fs::exists(folder.path() / "a.geojson"));
}

TEST(Export, AnUnknownFormatIsAUsageError) {
  EXPECT_EQ(parse_export_format("obj").error().code, Errc::usage);
  EXPECT_EQ(parse_export_format("vtu").value(), ExportFormat::vtu);
}

TEST(Export, ADamagedTileLeavesNothingHalfWritten) {
  for (const auto format : {ExportFormat::ply, ExportFormat::off, ExportFormat::vtu, ExportFormat::geojson}) {
    const TemporaryFolder folder, target;
    store_sample(folder.path(), sample_tiles(sample_points(Shape::uniform, 2, 200), 2, 4));
    fs::resize_file(tile_file(folder.path(), TileId{2}), 3000);
    for (const char* name : {"mesh.vtu", "parts"}) {
      if (format != ExportFormat::vtu && name == std::string("parts")) continue;
      const auto result = export_result(folder.path(), format, target.path() / name, {});
      ASSERT_FALSE(result);
      EXPECT_EQ(result.error().code, Errc::corrupt);
      EXPECT_TRUE(fs::is_empty(target.path()));
    }
  }
}

TEST(Export, StopsWhenAskedAndLeavesNothing) {
  const TemporaryFolder folder, target;
  store_sample(folder.path(), sample_tiles(sample_points(Shape::uniform, 3, 200), 3, 2));
  std::stop_source stop;
  stop.request_stop();
  const auto result = export_result(folder.path(), ExportFormat::ply, target.path() / "a.ply", stop.get_token());
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, Errc::interrupted);
  EXPECT_TRUE(fs::is_empty(target.path()));
}

TEST(Export, AFolderThatDoesNotExistIsAnIoError) {
  const TemporaryFolder folder;
  store_sample(folder.path(), sample_tiles(sample_points(Shape::uniform, 3, 50), 3, 1));
  const auto result = export_result(folder.path(), ExportFormat::ply, folder.path() / "no" / "a.ply", {});
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, Errc::io);
}

TEST(Export, GeoJsonNamesTheCoordinateSystemWhenItIsKnown) {
  const TemporaryFolder folder;
  auto manifest = store_sample(folder.path(), sample_tiles(sample_points(Shape::uniform, 2, 20), 2, 1));
  manifest.crs = "EPSG:2154";
  ASSERT_TRUE(finish_store(folder.path(), manifest, {}));
  ASSERT_TRUE(export_result(folder.path(), ExportFormat::geojson, folder.path() / "a.geojson", {}));
  std::ifstream file(folder.path() / "a.geojson");
  const std::string text((std::istreambuf_iterator<char>(file)), {});
  EXPECT_NE(text.find("urn:ogc:def:crs:EPSG::2154"), std::string::npos);
}

TEST(Export, FindsTheEpsgCodeOfTheHorizontalSystem) {
  using store::epsg_code;
  EXPECT_EQ(epsg_code("EPSG:32631"), "32631");
  EXPECT_EQ(epsg_code("EPSG:x"), "");
  EXPECT_EQ(epsg_code(""), "");
  const std::string geographic = R"(GEOGCS["RGF93",DATUM["d",AUTHORITY["EPSG","6171"]],AUTHORITY["EPSG","4171"]])";
  const std::string projected =
      "PROJCS[\"RGF93 / Lambert-93\"," + geographic + R"(,UNIT["metre",1],AUTHORITY["EPSG","2154"]])";
  EXPECT_EQ(epsg_code(projected), "2154");
  EXPECT_EQ(epsg_code("PROJCS[\"no authority\"," + geographic + "]"), "");
  EXPECT_EQ(
      epsg_code("COMPD_CS[\"c\"," + projected + R"(,VERT_CS["v",AUTHORITY["EPSG","5720"]],AUTHORITY["EPSG","5698"]])"),
      "2154");
  EXPECT_EQ(epsg_code(R"(PROJCRS["p [x]", BASEGEOGCRS["b",ID["EPSG",4326]], ID["EPSG",32631]])"), "32631");
}

}  // namespace
}  // namespace tessera
