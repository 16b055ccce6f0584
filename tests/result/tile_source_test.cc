#include "src/result/tile_source.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <stop_token>
#include <string>

#include "src/base/files/whole_file.h"
#include "src/result/store/manifest.h"
#include "tests/store/sample_result.h"

namespace tessera::test {
namespace {

namespace fs = std::filesystem;

class TileSourceOf : public testing::TestWithParam<int> {
 protected:
  TileSourceOf() {
    options_.schema = {{"intensity", AttributeType::u16}};
    manifest_ = store_sample(folder_.path(), meshes_, options_);
  }
  // The manifest with a lie in it.
  std::string read_with(const std::function<void(Manifest&)>& lie, const TileFields& parts = {}) {
    Manifest changed = manifest_;
    lie(changed);
    EXPECT_TRUE(write_whole(manifest_file(folder_.path()), store::manifest_to_text(changed)));
    const auto tile = TileSource::open(folder_.path()).value().read(1, parts);
    if (tile) return "";
    EXPECT_EQ(tile.error().code, Errc::corrupt) << tile.error().where;
    EXPECT_NE(tile.error().where.find("tiles/000001."), std::string::npos) << tile.error().where;
    return tile.error().where;
  }

  const TemporaryFolder folder_;
  const std::vector<TileMesh> meshes_ = sample_tiles(sample_points(Shape::uniform, GetParam(), 300), GetParam(), 3);
  StoreOptions options_;
  Manifest manifest_;
};

INSTANTIATE_TEST_SUITE_P(Dimensions, TileSourceOf, testing::Values(2, 3));

TEST_P(TileSourceOf, GivesWhatIsAskedForOfATileAndNoMore) {
  const auto source = TileSource::open(folder_.path()).value();
  ASSERT_EQ(source.tiles(), 3u);
  for (std::size_t i = 0; i < source.tiles(); ++i) {
    EXPECT_EQ(source.find(source.entry(i).tile), i);
    const auto whole = source.read(i, {.rows = true}).value();
    EXPECT_EQ(whole.mesh.cells, meshes_[i].cells);
    EXPECT_EQ(whole.mesh.ids, meshes_[i].ids);
    EXPECT_EQ(whole.rows.size(), 2 * meshes_[i].ids.size());
    EXPECT_TRUE(source.read(i, {}).value().rows.empty());
    const auto vertices = source.read(i, {.cells = false}).value();
    EXPECT_EQ(vertices.mesh.points, meshes_[i].points);
    EXPECT_TRUE(vertices.mesh.cells.empty());
    std::vector<PointId> own;
    for (std::size_t v = 0; v < meshes_[i].ids.size(); ++v)
      if (meshes_[i].point_ghost[v] == 0) own.push_back(meshes_[i].ids[v]);
    EXPECT_EQ(source.read_own_ids(i).value(), own);
  }
  EXPECT_FALSE(source.find(TileId{3}));
}

TEST_P(TileSourceOf, ATileThatIsNotWhatTheManifestSaysIsCorrupt) {
  EXPECT_EQ(read_with([](Manifest&) {}), "");
  const std::string numbers = "holds other numbers of vertices or cells than the manifest says";
  const auto says = [](const std::string& text, const std::string& words) {
    return text.find(words) != std::string::npos;
  };
  EXPECT_TRUE(says(read_with([](Manifest& m) { ++m.tiles[1].points; }), numbers));
  EXPECT_TRUE(says(read_with([](Manifest& m) { --m.tiles[1].own_points; }), numbers));
  EXPECT_TRUE(says(read_with([](Manifest& m) { ++m.tiles[1].cells; }), numbers));
  EXPECT_TRUE(says(read_with([](Manifest& m) { --m.tiles[1].main_cells; }), numbers));
  EXPECT_TRUE(says(read_with([](Manifest& m) { ++m.tiles[1].own_points; }, {.cells = false}), numbers));
  EXPECT_TRUE(says(read_with([](Manifest& m) { ++m.tiles[1].bytes; }), "bytes, but the manifest says"));
  EXPECT_TRUE(says(read_with([](Manifest& m) { m.neighbors = false; }), "neighbours"));
  EXPECT_TRUE(says(read_with([](Manifest& m) { m.schema[0].name = "other"; }), "attributes"));
  EXPECT_EQ(read_with([](Manifest& m) { ++m.tiles[1].cells; }, {.cells = false}), "") << "nobody asked for them";
}

TEST_P(TileSourceOf, ATileKeptAsPointsThatIsNotWhatTheManifestSaysIsCorrupt) {
  fs::remove_all(tiles_folder(folder_.path()));
  manifest_ = store_sample(folder_.path(), meshes_, options_, {}, {}, [](TileId) { return TileKind::points; });
  EXPECT_EQ(read_with([](Manifest&) {}), "");
  const std::string place = "tiles/000001.pts: ", says = " than the manifest says";
  const auto expect = [&](const std::function<void(Manifest&)>& lie, const std::string& what) {
    const std::string text = read_with(lie, {.cells = false});
    EXPECT_TRUE(text.ends_with(place + what + says)) << text;
  };
  const std::string numbers = "holds other numbers of vertices or cells";
  expect([](Manifest& m) { ++m.tiles[1].points; }, numbers);
  expect([](Manifest& m) { --m.tiles[1].own_points; }, numbers);
  expect([](Manifest& m) { ++m.tiles[1].cells; }, numbers);
  expect([](Manifest& m) { m.schema[0].name = "other"; }, "has other attributes");
  expect(
      [](Manifest& m) {
        m.format_version = changed_format;
        m.version = 2;
        m.columns.emplace_back();
        m.columns[0].name = "volume";
        m.columns[0].of_cells = true;
      },
      "has other columns of cells");
  EXPECT_TRUE(read_with([](Manifest& m) { --m.tiles[1].main_cells; }).ends_with(place + numbers + says));
}

TEST_P(TileSourceOf, ATileKeptAsPointsOfWhichTwoForeignVerticesHaveOneIdIsCorrupt) {
  fs::remove_all(tiles_folder(folder_.path()));
  auto meshes = meshes_;
  std::vector<PointId>& ids = meshes[1].ids;
  const std::size_t own =
      ids.size() - static_cast<std::size_t>(std::count(meshes[1].point_ghost.begin(), meshes[1].point_ghost.end(), 1));
  ASSERT_GE(ids.size(), own + 2);
  ids[own + 1] = ids[own];
  manifest_ = store_sample(folder_.path(), meshes, options_, {}, {}, [](TileId) { return TileKind::points; });
  const std::string text = read_with([](Manifest&) {});
  EXPECT_TRUE(text.ends_with("tiles/000001.pts: two foreign vertices have one id")) << text;
}

TEST_P(TileSourceOf, ATileKeptAsPointsIsNotMadeWhenNobodyWantsItAnyMore) {
  fs::remove_all(tiles_folder(folder_.path()));
  store_sample(folder_.path(), meshes_, options_, {}, {}, [](TileId) { return TileKind::points; });
  std::stop_source stop;
  const auto source = TileSource::open(folder_.path()).value().stopped_by(stop.get_token());
  EXPECT_TRUE(source.read(1, {}));
  stop.request_stop();
  const auto stopped = source.read(1, {});
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, Errc::interrupted) << stopped.error().where;
  EXPECT_TRUE(source.read(1, {.cells = false})) << "this takes no time";
}

TEST_P(TileSourceOf, WhatIsNoResultIsTold) {
  EXPECT_EQ(TileSource::open(folder_.path() / "none").error().code, Errc::io);
  std::ofstream(manifest_file(folder_.path()), std::ios::trunc) << "{";
  EXPECT_EQ(TileSource::open(folder_.path()).error().code, Errc::corrupt);
}

}  // namespace
}  // namespace tessera::test
