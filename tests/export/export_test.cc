// Refusals, names, and what is left behind. What the formats hold is read back by other people's readers: by CGAL in
// read_by_cgal_test.cc, by VTK, GDAL, Gmsh and NumPy in read_back_test.py.
#include "src/result/export/export.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <fstream>
#include <iterator>
#include <limits>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/files/whole_file.h"
#include "src/base/option.h"
#include "src/result/new_version.h"
#include "tests/store/sample_result.h"

namespace tessera::test {
namespace {

namespace fs = std::filesystem;

const char* const flat_formats[] = {"ply", "vtu",  "off", "obj",     "stl",     "glb",  "mesh",
                                    "msh", "mshb", "dxf", "landxml", "geojson", "gpkg", "csv"};

void store_flat(const fs::path& out, std::size_t n = 200) {
  store_sample(out, sample_tiles(sample_points(Shape::uniform, 2, n), 2, 4));
}

void store_solid(const fs::path& out) { store_sample(out, sample_tiles(sample_points(Shape::uniform, 3, 60), 3, 2)); }

TEST(Export, FormatsWithoutTetrahedraRefuseThemInOneSentence) {
  const TemporaryFolder folder, target;
  store_solid(folder.path());
  for (const std::string name : {"obj", "stl", "glb", "dxf", "landxml", "geojson", "gpkg", "csv"}) {
    const auto result = export_result(folder.path(), target.path() / ("a." + name), {}, {});
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, Errc::usage);
    EXPECT_NE(result.error().where.find(name), std::string::npos);
  }
  EXPECT_TRUE(fs::is_empty(target.path()));
}

TEST(Export, AnUnknownFormatIsRefusedBeforeAnythingIsRead) {
  for (const std::string target : {"a.3ds", "a", "tiles/"}) {
    const auto result = export_result("no such folder", target, {}, {});
    ASSERT_FALSE(result) << target;
    EXPECT_EQ(result.error().code, Errc::usage) << target;
  }
  EXPECT_EQ(export_result("no such folder", "a.ply", {.format = "las"}, {}).error().code, Errc::usage);
  EXPECT_EQ(export_result("no such folder", "arrays.npy", {.format = "npy"}, {}).error().code, Errc::usage);
  EXPECT_EQ(export_result("no such folder", "points/", {.format = "h5"}, {}).error().code, Errc::usage);
  EXPECT_EQ(export_result("no such folder", "a.ply", {}, {}).error().code, Errc::io);
}

TEST(Export, ADamagedTileLeavesNothingHalfWritten) {
  const TemporaryFolder folder;
  store_flat(folder.path());
  fs::resize_file(tile_file(folder.path(), TileId{2}), 3000);
  std::vector<std::string> names(std::begin(flat_formats), std::end(flat_formats));
  names.push_back("npy");
  for (const std::string& name : names) {
    const TemporaryFolder target;
    for (const std::string& path : {"mesh." + name, std::string("tiles")}) {
      if (path == "mesh.npy") continue;
      const auto result = export_result(folder.path(), target.path() / path, {.format = name}, {});
      ASSERT_FALSE(result) << name;
      EXPECT_EQ(result.error().code, Errc::corrupt) << name;
      EXPECT_TRUE(fs::is_empty(target.path())) << name;
    }
  }
}

TEST(Export, ADamagedTileIsFoundWhenCellsAreChosen) {
  const TemporaryFolder folder, target;
  store_flat(folder.path());
  fs::resize_file(tile_file(folder.path(), TileId{2}), 3000);
  for (const std::string name : flat_formats) {
    const auto result = export_result(folder.path(), target.path() / ("a." + name), {.max_edge = 0.2}, {});
    ASSERT_FALSE(result) << name;
    EXPECT_EQ(result.error().code, Errc::corrupt) << name;
  }
  EXPECT_TRUE(fs::is_empty(target.path()));
}

TEST(Export, TilesThatAreNotWhatTheManifestCountsAreCorrupt) {
  const TemporaryFolder folder;
  const auto whole = store_sample(folder.path(), sample_tiles(sample_points(Shape::uniform, 2, 200), 2, 4));
  const auto refused = [&](auto change, const std::string& says) {
    auto manifest = whole;
    change(manifest);
    ASSERT_TRUE(finish_store(folder.path(), manifest, {}));
    for (const std::string name : {"a.vtu", "a.csv", "a.gpkg", "tiles"}) {
      for (const auto& max_edge : {std::optional<double>(), std::optional<double>(0.2)}) {
        const TemporaryFolder target;
        const ExportOptions options{.format = name == "tiles" ? "ply" : "", .max_edge = max_edge};
        const auto result = export_result(folder.path(), target.path() / name, options, {});
        ASSERT_FALSE(result) << name << says;
        EXPECT_EQ(result.error().code, Errc::corrupt);
        EXPECT_NE(result.error().where.find(says), std::string::npos) << result.error().where;
        EXPECT_TRUE(fs::is_empty(target.path()));
      }
    }
  };
  refused([](Manifest& m) { ++m.tiles[1].own_points, ++m.vertices; },
          "numbers of vertices or cells than the manifest says");
  refused([](Manifest& m) { ++m.tiles[1].main_cells, ++m.cells; },
          "numbers of vertices or cells than the manifest says");
  refused([](Manifest& m) { --m.tiles[3].main_cells, --m.cells; },
          "numbers of vertices or cells than the manifest says");
  refused([](Manifest& m) { ++m.cells; }, "but its list of tiles counts");
}

TEST(Export, StopsWhenAskedAndLeavesNothing) {
  const TemporaryFolder folder, target;
  store_flat(folder.path());
  std::stop_source stop;
  stop.request_stop();
  for (const std::string name : flat_formats) {
    for (const auto& max_edge : {std::optional<double>(), std::optional<double>(0.2)}) {
      const ExportOptions options{.max_edge = max_edge};
      const auto result = export_result(folder.path(), target.path() / ("a." + name), options, stop.get_token());
      ASSERT_FALSE(result) << name;
      EXPECT_EQ(result.error().code, Errc::interrupted) << name;
      EXPECT_TRUE(fs::is_empty(target.path())) << name;
    }
  }
}

TEST(Export, WhatExistsIsReplacedOnlyOnDemand) {
  const TemporaryFolder folder, target;
  store_flat(folder.path());
  for (const std::string name : {"a.ply", "a.vrt", "a.gpkg", "tiles"}) {
    const ExportOptions options{.format = name == "tiles" ? "vtu" : ""};
    ASSERT_TRUE(export_result(folder.path(), target.path() / name, options, {})) << name;
    const auto again = export_result(folder.path(), target.path() / name, options, {});
    ASSERT_FALSE(again) << name;
    EXPECT_NE(in_plain_words(again.error().where).find("overwrite=true"), std::string::npos);
    ASSERT_TRUE(export_result(folder.path(), target.path() / name, {.format = options.format, .overwrite = true}, {}));
  }
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(target.path())) names.insert(entry.path().filename());
  EXPECT_EQ(names, (std::set<std::string>{"a.csv", "a.gpkg", "a.ply", "a.vrt", "tiles"}));
}

TEST(Export, ATableAndItsLayerAreWrittenBothOrNeither) {
  const TemporaryFolder folder, target;
  store_flat(folder.path());
  fs::create_directory(target.path() / "a.vrt");
  const auto result = export_result(folder.path(), target.path() / "a.csv", {.overwrite = true}, {});
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, Errc::usage);
  EXPECT_EQ(std::distance(fs::directory_iterator(target.path()), fs::directory_iterator()), 1);
}

// A column of cells has one value everywhere.
void add_cell_columns(const fs::path& out, const std::vector<std::pair<Attribute, std::vector<std::byte>>>& columns) {
  const auto next = NewVersion::begin(out).value();
  for (std::size_t i = 0; i < next->source().tiles(); ++i) {
    std::vector<std::vector<std::byte>> values;
    std::vector<store::ColumnValues> made;
    for (const auto& [as, value] : columns) {
      auto& all = values.emplace_back();
      for (std::uint64_t cell = 0; cell < next->source().entry(i).cells; ++cell)
        all.insert(all.end(), value.begin(), value.end());
    }
    for (std::size_t c = 0; c < columns.size(); ++c) made.push_back({true, columns[c].first, values[c]});
    ASSERT_TRUE(next->add_columns(i, made, {}));
  }
  std::vector<ResultColumn> described;
  for (const auto& column : columns)
    described.push_back({.name = column.first.name,
                         .of_cells = true,
                         .type = column.first.type,
                         .unit = "",
                         .command = {},
                         .software_version = ""});
  ASSERT_TRUE(next->commit(described));
}

template <class Value>
std::vector<std::byte> bytes_of(Value value) {
  const auto bytes = std::as_bytes(std::span(&value, 1));
  return {bytes.begin(), bytes.end()};
}

std::string text_of(const fs::path& path) { return std::string(as_text(read_whole(path).value())); }

TEST(Export, TablesHoldColumnsOfCellsOfAnyNameAndType) {
  const TemporaryFolder folder, target;
  store_flat(folder.path());
  constexpr double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  add_cell_columns(folder.path(), {{{"a \"b\", <c>", AttributeType::u64}, bytes_of(~std::uint64_t{0})},
                                   {{"V0", AttributeType::i8}, bytes_of(std::int8_t{-5})},
                                   {{"v0", AttributeType::f32}, bytes_of(0.1F)},
                                   {{"none", AttributeType::f64}, bytes_of(nan)},
                                   {{"longest_edge", AttributeType::f64}, bytes_of(-infinity)}});
  ASSERT_TRUE(export_result(folder.path(), target.path() / "a.csv", {}, {}));
  const std::string table = text_of(target.path() / "a.csv");
  EXPECT_TRUE(table.starts_with("geom,tid,local,main,v0,v1,v2,\"a \"\"b\"\", <c>\",V0_,v0__,none,longest_edge\n"))
      << table.substr(0, 200);
  EXPECT_TRUE(table.ends_with(",18446744073709551615,-5,0.10000000149011612,,-inf\n"))
      << table.substr(table.size() - 99);
  const std::string index = text_of(target.path() / "a.vrt");
  for (const std::string field : {"<Field name=\"a &quot;b&quot;, &lt;c&gt;\" type=\"Real\"/>",
                                  "<Field name=\"V0_\" type=\"Integer64\"/>", "<Field name=\"v0__\" type=\"Real\"/>"})
    EXPECT_NE(index.find(field), std::string::npos) << field << " in " << index;
  ASSERT_TRUE(export_result(folder.path(), target.path() / "a.msh", {}, {}));
  const std::string mesh = text_of(target.path() / "a.msh");
  for (const std::string name : {"longest_edge", "longest_edge_", "a 'b', <c>", "V0", "v0_", "none"})
    EXPECT_NE(mesh.find("$ElementData\n1\n\"" + name + "\"\n"), std::string::npos) << name;
}

TEST(Export, FilesOfAnotherExportDoNotStayAmongNewOnes) {
  const TemporaryFolder folder, target;
  store_flat(folder.path());
  const fs::path tiles = target.path() / "tiles";
  ASSERT_TRUE(export_result(folder.path(), tiles, {.format = "ply"}, {}));
  fs::copy(tiles / "000000.ply", tiles / "000017.ply");
  const auto result = export_result(folder.path(), tiles, {.format = "ply", .overwrite = true}, {});
  ASSERT_FALSE(result);
  EXPECT_NE(result.error().where.find("000017.ply"), std::string::npos);
  fs::rename(tiles / "000017.ply", tiles / "notes.txt");
  EXPECT_TRUE(export_result(folder.path(), tiles, {.format = "ply", .overwrite = true}, {}));
  EXPECT_TRUE(fs::exists(tiles / "notes.txt"));
  EXPECT_EQ(std::distance(fs::directory_iterator(target.path()), fs::directory_iterator()), 1);
}

TEST(Export, AFolderThatDoesNotExistIsAnIoError) {
  const TemporaryFolder folder;
  store_flat(folder.path());
  for (const std::string name : flat_formats) {
    for (const std::string& file : {"a." + name, std::string("tiles")}) {
      const auto result = export_result(folder.path(), folder.path() / "no" / file, {.format = name}, {});
      ASSERT_FALSE(result) << name;
      EXPECT_EQ(result.error().code, Errc::io) << name;
      EXPECT_FALSE(fs::exists(folder.path() / "no"));
    }
  }
}

TEST(Export, ACoordinateSystemThatGdalDoesNotUnderstandIsNamed) {
  const TemporaryFolder folder, target;
  auto manifest = store_sample(folder.path(), sample_tiles(sample_points(Shape::uniform, 2, 20), 2, 1));
  manifest.crs = "PROJCS[\"nonsense\"]";
  ASSERT_TRUE(finish_store(folder.path(), manifest, {}));
  for (const std::string name : {"a.geojson", "a.gpkg", "a.xml"}) {
    const auto result = export_result(folder.path(), target.path() / name, {}, {});
    ASSERT_FALSE(result) << name;
    EXPECT_EQ(result.error().code, Errc::bad_input);
    EXPECT_NE(result.error().where.find("coordinate system"), std::string::npos);
  }
  EXPECT_TRUE(fs::is_empty(target.path()));
}

TEST(Crs, AnythingElseIsLeftOutWithANote) {
  const TemporaryFolder folder, target;
  auto manifest = store_sample(folder.path(), sample_tiles(sample_points(Shape::uniform, 2, 20), 2, 1));
  const fs::path lure = target.path() / "lure.wkt";
  std::ofstream(lure) << "PROJCS[\"lure\"]";
  manifest.crs = lure;
  ASSERT_TRUE(finish_store(folder.path(), manifest, {}));
  for (const std::string name : {"a.geojson", "a.gpkg", "a.csv"}) {
    const auto result = export_result(folder.path(), target.path() / name, {}, {});
    ASSERT_TRUE(result) << name;
    EXPECT_NE(result.value().note.find("neither EPSG:n nor WKT"), std::string::npos);
  }
  std::ifstream file(target.path() / "a.vrt");
  const std::string text((std::istreambuf_iterator<char>(file)), {});
  EXPECT_EQ(text.find("lure"), std::string::npos);
}

}  // namespace
}  // namespace tessera::test
