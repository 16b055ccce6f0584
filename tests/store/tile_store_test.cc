#include "src/result/store/tile_store.h"

#include <gtest/gtest.h>
#include <sys/mount.h>
#include <sys/resource.h>

#include <csignal>
#include <cstring>
#include <fstream>
#include <limits>
#include <thread>

#include "src/base/files/checksum.h"
#include "src/base/files/whole_file.h"
#include "src/result/store/manifest.h"
#include "tests/store/sample_result.h"

namespace tessera::test {
namespace {

namespace fs = std::filesystem;

void expect_equal(const TileMesh& a, const TileMesh& b) {
  EXPECT_EQ(a.dimension, b.dimension);
  EXPECT_EQ(a.points, b.points);
  EXPECT_EQ(a.ids, b.ids);
  EXPECT_EQ(a.owners, b.owners);
  EXPECT_EQ(a.point_ghost, b.point_ghost);
  EXPECT_EQ(a.cells, b.cells);
  EXPECT_EQ(a.cell_ghost, b.cell_ghost);
  EXPECT_EQ(a.neighbors, b.neighbors);
}

std::vector<std::byte> bytes_of(const fs::path& path) { return read_whole(path).value(); }

void overwrite(const fs::path& path, const std::string& text) { std::ofstream(path, std::ios::trunc) << text; }

std::string text_of(const fs::path& path) {
  const auto bytes = bytes_of(path);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

class TileStore : public testing::TestWithParam<int> {};

TEST_P(TileStore, ReadsBackWhatWasWritten) {
  const TemporaryFolder folder;
  StoreOptions options;
  options.schema = {{"intensity", AttributeType::u16}, {"gps_time", AttributeType::f64}, {"class", AttributeType::u8}};
  const auto meshes = sample_tiles(sample_points(Shape::uniform, GetParam(), 400), GetParam(), 3);
  store_sample(folder.path(), meshes, options);
  for (std::uint32_t tile = 0; tile < 3; ++tile) {
    const auto read = read_tile(folder.path(), TileId{tile}, true);
    ASSERT_TRUE(read) << read.error().where;
    expect_equal(read.value().mesh, meshes[tile]);
    EXPECT_EQ(read.value().schema, options.schema);
    ASSERT_EQ(read.value().rows.size(), meshes[tile].points.size() * 11);
    for (std::size_t i = 0; i < read.value().rows.size(); ++i)
      ASSERT_EQ(read.value().rows[i], static_cast<std::byte>(i * 7));
  }
}
INSTANTIATE_TEST_SUITE_P(Dimensions, TileStore, testing::Values(2, 3));

TEST(TileStore, EqualMeshesGiveEqualFilesByteForByte) {
  const TemporaryFolder a, b;
  const auto meshes = sample_tiles(sample_points(Shape::uniform, 3, 2000), 3, 2);
  store_sample(a.path(), meshes);
  store_sample(b.path(), meshes);
  for (const char* name : {"tiles/000000.vtu", "tiles/000001.vtu", "triangulation.pvtu", "manifest.json"})
    EXPECT_EQ(bytes_of(a.path() / name), bytes_of(b.path() / name)) << name;
}

TEST(TileStore, ChecksumsAreThoseOfTheFiles) {
  const TemporaryFolder folder;
  const auto manifest = store_sample(folder.path(), sample_tiles(sample_points(Shape::uniform, 3, 500), 3, 2), {},
                                     {{600, 1}, {601, 1}, {602, 17}});
  for (const auto& entry : manifest.tiles) {
    const auto file = tile_file(folder.path(), entry.tile);
    EXPECT_EQ(checksum_file(file, ChecksumOf::pieces).value(), entry.xxh3);
    EXPECT_EQ(fs::file_size(file), entry.bytes);
  }
  EXPECT_EQ(checksum_file(folder.path() / "triangulation.pvtu").value(), manifest.master_xxh3);
  EXPECT_EQ(checksum_file(folder.path() / "duplicates.bin", ChecksumOf::pieces).value(), manifest.duplicates_xxh3);
}

TEST(TileStore, ArraysOfManyBlocksAreRight) {
  TileMesh mesh;
  mesh.dimension = 2;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.ids = {{0}, {1}, {2}};
  mesh.owners = {{7}, {7}, {7}};
  mesh.point_ghost = {0, 0, 0};
  for (int i = 0; i < 70000; ++i) {
    mesh.cells.insert(mesh.cells.end(), {0, 1, 2});
    mesh.cell_ghost.push_back(0);
    mesh.neighbors.insert(mesh.neighbors.end(), {-1, -1, -1});
  }
  const TemporaryFolder folder;
  ASSERT_TRUE(write_tile(folder.path(), TileId{7}, mesh, {}, {}));
  const auto read = read_tile(folder.path(), TileId{7});
  ASSERT_TRUE(read) << read.error().where;
  expect_equal(read.value().mesh, mesh);
  EXPECT_LT(fs::file_size(tile_file(folder.path(), TileId{7})), 70000u * 25 + 40000u);
}

TEST(TileStore, ATileWithoutCellsIsStored) {
  TileMesh mesh;
  mesh.points = {{1, 2, 3}};
  mesh.ids = {{5}};
  mesh.owners = {{0}};
  mesh.point_ghost = {0};
  const TemporaryFolder folder;
  store_sample(folder.path(), {mesh});
  const auto read = read_tile(folder.path(), TileId{0});
  ASSERT_TRUE(read) << read.error().where;
  expect_equal(read.value().mesh, mesh);
}

TEST(TileStore, WithoutNeighboursTheFileHasNone) {
  const TemporaryFolder folder;
  auto meshes = sample_tiles(sample_points(Shape::uniform, 3, 200), 3, 1);
  StoreOptions options;
  options.neighbors = false;
  store_sample(folder.path(), meshes, options);
  meshes[0].neighbors.clear();
  expect_equal(read_tile(folder.path(), TileId{0}).value().mesh, meshes[0]);
}

TEST(TileStore, ThreadsMayWriteDifferentTiles) {
  const TemporaryFolder folder;
  const auto meshes = sample_tiles(sample_points(Shape::uniform, 3, 1000), 3, 8);
  {
    std::vector<std::jthread> threads;
    for (std::uint32_t t = 0; t < 4; ++t)
      threads.emplace_back([&, t] {
        for (std::uint32_t tile = t; tile < 8; tile += 4)
          EXPECT_TRUE(write_tile(folder.path(), TileId{tile}, meshes[tile], {}, {}));
      });
  }
  EXPECT_EQ(stored_tiles(folder.path()).value().size(), 8u);
  const auto one = stored_tiles(folder.path(), [](TileId tile) { return tile == TileId{3}; });
  ASSERT_EQ(one.value().size(), 1u);
  EXPECT_EQ(one.value()[0].tile, TileId{3});
  for (std::uint32_t tile = 0; tile < 8; ++tile)
    expect_equal(read_tile(folder.path(), TileId{tile}).value().mesh, meshes[tile]);
}

TEST(TileStore, AttributesWhoseNameIsTakenGetAnother) {
  const TemporaryFolder folder;
  StoreOptions options;
  options.schema = {{"id", AttributeType::u32}, {"owner", AttributeType::u8}, {"a/b", AttributeType::f32}};
  const auto manifest = store_sample(folder.path(), sample_tiles(sample_points(Shape::uniform, 2, 50), 2, 1), options);
  const std::vector<Attribute> stored{
      {"id_", AttributeType::u32}, {"owner_", AttributeType::u8}, {"a_b", AttributeType::f32}};
  EXPECT_EQ(manifest.schema, stored);
  EXPECT_EQ(read_tile(folder.path(), TileId{0}).value().schema, stored);
  options.schema = {{"a/b", AttributeType::f32}, {"a_b", AttributeType::f32}};
  const auto refused = write_tile(folder.path(), TileId{0}, TileMesh{}, {}, options);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Errc::usage);
}

TEST(TileStore, NamesThatXmlCannotHoldAreStoredWithUnderscores) {
  const TemporaryFolder folder;
  StoreOptions options;
  options.schema = {{"a&lt;b>\"c\" & <d>", AttributeType::u32},
                    {"line\nend\x7f", AttributeType::u8},
                    {"h\xc3\xb6he \xf0\x9f\x8f\x94", AttributeType::u8},
                    {"latin \xf6 cut \xe2\x82", AttributeType::u8},
                    {"\xed\xa0\x80\xef\xbf\xbf\xc0\xaf", AttributeType::u8}};
  store_sample(folder.path(), sample_tiles(sample_points(Shape::uniform, 2, 50), 2, 1), options);
  const auto read = read_tile(folder.path(), TileId{0}, true);
  ASSERT_TRUE(read) << read.error().where;
  std::vector<std::string> names;
  for (const auto& attribute : read.value().schema) names.push_back(attribute.name);
  EXPECT_EQ(names, (std::vector<std::string>{"a&lt;b>\"c\" & <d>", "line_end_", "h\xc3\xb6he \xf0\x9f\x8f\x94",
                                             "latin _ cut __", "________"}));
}

TEST(Manifest, ReadsBackWhatWasWrittenToTheLastBit) {
  const TemporaryFolder folder;
  constexpr double inf = std::numeric_limits<double>::infinity();
  Manifest manifest =
      store_sample(folder.path(), sample_tiles(sample_points(Shape::uniform, 3, 100), 3, 2), {}, {{200, 3}});
  manifest.inputs = {{"a \"quoted\" cloud.las", 123456789012345, -5}};
  manifest.crs = "EPSG:2154";
  manifest.boxes = {{{-inf, 0.1, -1e308}, {1.0 / 3.0, 5e-324, inf}}, {{1.0 / 3.0, -inf, 2}, {inf, inf, inf}}};
  manifest.partition = R"({"dimension":3,"kind":"kdtree","splits":[[0,0.30000000000000004,-1,-2]],"tiles":2})";
  manifest.seconds = {{"routing", 0.1 + 0.2}};
  manifest.figures = {{"messages", 12}};
  const std::vector<DuplicatePair> duplicates{{200, 3}};
  manifest.other_heights = 1;
  manifest.tiles.at(0).heights = HeightRange{-1.25, 1e300};
  ASSERT_TRUE(finish_store(folder.path(), manifest, duplicates));
  const auto read = read_manifest(folder.path());
  ASSERT_TRUE(read) << read.error().where;
  EXPECT_EQ(read.value().format_version, unchanged_format);
  EXPECT_EQ(read.value().boxes, manifest.boxes);
  EXPECT_EQ(read.value().partition, manifest.partition);
  EXPECT_EQ(read.value().bounds, manifest.bounds);
  EXPECT_EQ(read.value().tiles, manifest.tiles);
  EXPECT_EQ(read.value().crs, manifest.crs);
  EXPECT_EQ(read.value().inputs.at(0).path, manifest.inputs[0].path);
  EXPECT_EQ(read.value().inputs.at(0).modified_ns, -5);
  EXPECT_EQ(read.value().seconds, manifest.seconds);
  EXPECT_EQ(read.value().figures, manifest.figures);
  EXPECT_EQ(read.value().master_xxh3, manifest.master_xxh3);
  EXPECT_EQ(read_duplicates(folder.path(), read.value()).value(), duplicates);
  EXPECT_EQ(read.value().keep, DuplicatePolicy::first);
  EXPECT_EQ(read.value().other_heights, 1u);
  EXPECT_EQ(heights_of(read.value()), (HeightRange{-1.25, 1e300}));
  EXPECT_EQ(store::manifest_to_text(read.value()), store::manifest_to_text(manifest));
}

TEST(Manifest, TellsWhichOfEqualPointsIsKeptAndDuplicatesFitToIt) {
  const TemporaryFolder folder;
  Manifest manifest = store_sample(folder.path(), sample_tiles(sample_points(Shape::uniform, 2, 50), 2, 1));
  const auto read_as = [&](DuplicatePolicy keep, const std::vector<DuplicatePair>& duplicates) {
    manifest.keep = keep;
    EXPECT_TRUE(finish_store(folder.path(), manifest, duplicates));
    const auto read = read_manifest(folder.path());
    EXPECT_EQ(read.value().keep, keep);
    const auto pairs = read_duplicates(folder.path(), read.value());
    return pairs ? std::string() : pairs.error().where.substr(pairs.error().where.find(", ") + 2);
  };
  EXPECT_EQ(read_as(DuplicatePolicy::last, {{3, 200}, {4, 200}}), "");
  EXPECT_EQ(read_as(DuplicatePolicy::lowest, {{3, 200}, {201, 4}}), "");
  EXPECT_EQ(read_as(DuplicatePolicy::first, {{3, 200}}), "pair 0: the kept point comes after its duplicate");
  EXPECT_EQ(read_as(DuplicatePolicy::last, {{2, 7}, {200, 3}}), "pair 1: the kept point comes before its duplicate");
  EXPECT_EQ(read_as(DuplicatePolicy::highest, {{2, 7}, {200, 200}}), "pair 1: the kept point is its own duplicate");
  EXPECT_EQ(heights_of(manifest), std::nullopt) << "nobody knows any";
}

TEST(Manifest, AFolderWithoutOneIsToldSo) {
  const TemporaryFolder folder;
  const auto read = read_manifest(folder.path());
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().code, Errc::io);
}

TEST(Manifest, OneFromAFutureVersionIsRefusedInOneSentence) {
  const TemporaryFolder folder;
  overwrite(folder.path() / "manifest.json", R"({"format": "tessera", "format_version": 7, "new": true})");
  const auto read = read_manifest(folder.path());
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().code, Errc::corrupt);
  EXPECT_NE(read.error().where.find("format version 7"), std::string::npos) << read.error().where;
}

TEST(Manifest, EveryTruncationAndAbsurdValueIsCorrupt) {
  const TemporaryFolder folder;
  StoreOptions options;
  options.schema = {{"intensity", AttributeType::u16}};
  store_sample(folder.path(), sample_tiles(sample_points(Shape::uniform, 3, 60), 3, 2), options);
  const auto path = folder.path() / "manifest.json";
  const std::string good = text_of(path);
  for (std::size_t n = 0; n + 2 < good.size(); n += 37) {
    overwrite(path, good.substr(0, n));
    const auto read = read_manifest(folder.path());
    ASSERT_FALSE(read) << n;
    EXPECT_EQ(read.error().code, Errc::corrupt) << n;
  }
  for (const auto& [from, to] :
       std::vector<std::pair<std::string, std::string>>{{"\"dimension\": 3", "\"dimension\": 4"},
                                                        {"\"cells\": ", "\"cells\": -"},
                                                        {"\"tile\":1", "\"tile\":0"},
                                                        {"\"xxh3\":\"", "\"xxh3\":\"g"},
                                                        {"\"-inf\"", "\"minus\""},
                                                        {"\"name\": \"", "\"name\": \"../"},
                                                        {"\"vertices\": ", "\"vertixes\": "}}) {
    std::string bad = good;
    ASSERT_NE(bad.find(from), std::string::npos) << from;
    bad.replace(bad.find(from), from.size(), to);
    overwrite(path, bad);
    const auto read = read_manifest(folder.path());
    ASSERT_FALSE(read) << to;
    EXPECT_EQ(read.error().code, Errc::corrupt) << to;
  }
}

// Readers of points make +0 of it, so that equal coordinates are equal bits: a file that has it is not ours.
TEST(TileFile, ACoordinateOfMinusZeroIsDamage) {
  for (const int dimension : {2, 3}) {
    for (int axis = 0; axis < 3; ++axis) {
      const TemporaryFolder folder;
      TileMesh mesh = sample_tiles(sample_points(Shape::lattice, dimension, 20), dimension, 1)[0];
      const auto zero =
          std::find_if(mesh.points.begin(), mesh.points.end(), [&](const Point& p) { return p[axis] == 0; });
      ASSERT_NE(zero, mesh.points.end());
      ASSERT_TRUE(write_tile(folder.path(), TileId{0}, mesh, {}, {}));
      EXPECT_TRUE(read_tile(folder.path(), TileId{0}));
      (*zero)[axis] = -0.0;
      ASSERT_TRUE(write_tile(folder.path(), TileId{0}, mesh, {}, {}));
      const auto read = read_tile(folder.path(), TileId{0});
      ASSERT_FALSE(read);
      EXPECT_EQ(read.error().code, Errc::corrupt);
      EXPECT_NE(read.error().where.find("has the coordinate -0"), std::string::npos) << read.error().where;
    }
  }
}

TEST(TileFile, AMissingTileIsAnIoError) {
  const TemporaryFolder folder;
  const auto read = read_tile(folder.path(), TileId{3});
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().code, Errc::io);
}

// Every size of a small disk, from one on which nothing fits to one on which all but the last bytes do.
TEST(TileStore, AFullDiskIsAnIoErrorAndLeavesNoTemporaryFile) {
  const TemporaryFolder folder;
  const auto mesh = sample_tiles(sample_points(Shape::uniform, 3, 3000), 3, 1)[0];
  for (const int kilobytes : {4, 16, 64, 200, 400, 640}) {
    const std::string size = "size=" + std::to_string(kilobytes) + "k";
    if (::mount("tmpfs", folder.path().c_str(), "tmpfs", 0, size.c_str()) != 0) GTEST_SKIP() << "mounting needs root";
    const auto entry = write_tile(folder.path(), TileId{0}, mesh, {}, {});
    EXPECT_FALSE(entry) << kilobytes;
    if (!entry) {
      EXPECT_EQ(entry.error().code, Errc::io);
    }
    EXPECT_TRUE(fs::is_empty(tiles_folder(folder.path())));
    EXPECT_EQ(::umount2(folder.path().c_str(), MNT_DETACH), 0);
  }
}

TEST(TileStore, AWriteThatTheSystemRefusesIsAnIoErrorAndLeavesNoTemporaryFile) {
  const TemporaryFolder folder;
  const auto mesh = sample_tiles(sample_points(Shape::uniform, 3, 3000), 3, 1)[0];
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ::getrlimit(RLIMIT_FSIZE, &before);
  for (const rlim_t bytes : {100, 2000, 5000, 100000, 600000}) {
    const rlimit limit{bytes, before.rlim_max};
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &limit), 0);
    const auto entry = write_tile(folder.path(), TileId{0}, mesh, {}, {});
    ::setrlimit(RLIMIT_FSIZE, &before);
    ASSERT_FALSE(entry) << bytes;
    EXPECT_EQ(entry.error().code, Errc::io);
    EXPECT_TRUE(fs::is_empty(tiles_folder(folder.path())));
  }
  EXPECT_TRUE(write_tile(folder.path(), TileId{0}, mesh, {}, {}));
  EXPECT_TRUE(read_tile(folder.path(), TileId{0}));
}

}  // namespace
}  // namespace tessera::test
