// Files and a manifest that do not belong together, also when whoever changed them mended every checksum.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <limits>

#include "src/base/files/checksum.h"
#include "src/base/files/whole_file.h"
#include "src/result/store/manifest.h"
#include "src/result/store/vtk_xml.h"
#include "src/tiling/partition.h"
#include "tests/verify/verify_testing.h"

namespace tessera::test {
namespace {

namespace fs = std::filesystem;
using Pairs = std::vector<DuplicatePair>;

TEST(Verify, AFlippedByteIsACorruptFileWhereverItIs) {
  const TemporaryFolder folder;
  store_sample(folder.path(), sample_tiles(sample_points(Shape::uniform, 3, 100), 3, 2), {}, {{100, 5}});
  for (const auto& path :
       {tile_file(folder.path(), TileId{1}), folder.path() / "triangulation.pvtu", folder.path() / "duplicates.bin"}) {
    const auto size = fs::file_size(path);
    for (std::uintmax_t at = size / 7; at < size; at += size / 5 + 1) {
      std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
      file.seekg(static_cast<std::streamoff>(at));
      const char byte = static_cast<char>(file.get());
      file.seekp(static_cast<std::streamoff>(at)).put(static_cast<char>(byte ^ 4)).flush();
      const auto result = verify(folder.path(), {}, {});
      ASSERT_FALSE(result);
      EXPECT_EQ(result.error().code, Errc::corrupt);
      EXPECT_NE(result.error().where.find(path.filename().string()), std::string::npos) << result.error().where;
      file.seekp(static_cast<std::streamoff>(at)).put(byte);
    }
  }
  EXPECT_TRUE(verify(folder.path(), {}, {}));
}

TEST(Verify, ATileThatIsGoneIsAnIoError) {
  const TemporaryFolder folder;
  store_sample(folder.path(), sample_tiles(sample_points(Shape::uniform, 3, 100), 3, 2));
  fs::remove(tile_file(folder.path(), TileId{1}));
  const auto result = verify(folder.path(), {}, {});
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, Errc::io);
}

TEST(Verify, PointsThatWereLostAreMissed) {
  const TemporaryFolder folder;
  const auto meshes = sample_tiles(sample_points(Shape::uniform, 3, 100), 3, 2);
  const Pairs duplicates{{100, 5}, {101, 6}};
  Manifest manifest = store_sample(folder.path(), meshes, {}, duplicates);
  const auto verify_with = [&](const std::function<void(Manifest&)>& change, const auto& pairs) {
    Manifest changed = manifest;
    change(changed);
    EXPECT_TRUE(finish_store(folder.path(), changed, pairs));
    return verify(folder.path(), {}, {});
  };
  EXPECT_TRUE(verify_with([](Manifest&) {}, duplicates));
  EXPECT_TRUE(verify_with([](Manifest& m) { m.points_read += m.filtered = 3; }, duplicates));
  using Change = std::function<void(Manifest&)>;
  const std::vector<std::pair<Change, Pairs>> losses{
      {[](Manifest& m) { ++m.points_read; }, duplicates},
      {[](Manifest& m) { ++m.vertices; }, duplicates},
      {[](Manifest& m) { ++m.cells; }, duplicates},
      {[](Manifest&) {}, Pairs(1, {100, 5})},             // one pair is missing
      {[](Manifest&) {}, Pairs({{99, 5}, {100, 6}})},     // 99 is a vertex
      {[](Manifest&) {}, Pairs({{100, 5}, {102, 101}})},  // 101 is none
  };
  for (const auto& [change, pairs] : losses) {
    const auto result = verify_with(change, pairs);
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, Errc::not_delaunay) << result.error().where;
  }
}

TEST(Verify, AnOwnVertexOutsideItsTilesBoxIsFound) {
  const TemporaryFolder folder;
  Manifest manifest = store_sample(folder.path(), sample_tiles(sample_points(Shape::uniform, 3, 100), 3, 2));
  manifest.boxes.at(1).lo.x = 0.9;
  ASSERT_TRUE(finish_store(folder.path(), manifest, {}));
  const auto result = verify(folder.path(), {}, {});
  ASSERT_FALSE(result);
  EXPECT_NE(result.error().where.find("outside the tile's box"), std::string::npos);
}

// A sound result in a folder, and what a forger needs to change it.
struct Sound {
  TemporaryFolder folder;
  fs::path out = folder.path();
  std::vector<TileMesh> meshes = sample_tiles(sample_points(Shape::uniform, 3, 300), 3, 3);
  StoreOptions options{true, {{"intensity", AttributeType::u16}}};
  Manifest manifest = store_sample(out, meshes, options, {{300, 5}});

  // Stores tile 1 again, with a checksum and a size that are right.
  void restore(const TileMesh& mesh, const StoreOptions& with) {
    const std::vector<std::byte> rows(mesh.points.size() * row_bytes(with.schema));
    const auto entry = write_tile(out, TileId{1}, mesh, rows, with);
    ASSERT_TRUE(entry) << entry.error().where;
    const auto digest = manifest.tiles[1].digest;
    manifest.tiles[1] = entry.value();
    manifest.tiles[1].digest = digest;
  }
  void write_master(std::span<const std::byte> bytes) {
    ASSERT_TRUE(write_whole(master_file(out), bytes));
    manifest.master_xxh3 = checksum(bytes);
  }
  void make_master(const Manifest& of) {
    const std::string text = store::master_text(of);
    write_master(std::as_bytes(std::span(text)));
  }
  void write_duplicates(const Pairs& pairs) {
    ASSERT_TRUE(write_whole(duplicates_file(out), std::as_bytes(std::span(pairs))));
    manifest.duplicates_xxh3 = checksum_file(duplicates_file(out), ChecksumOf::pieces).value();
    manifest.duplicates = pairs.size();
  }
};

TileMesh with_foreign_owner(TileMesh mesh, std::uint32_t owner) {
  for (std::size_t i = 0; i < mesh.owners.size(); ++i)
    if (mesh.point_ghost[i] != 0) mesh.owners[i] = TileId{owner};
  return mesh;
}

struct Forgery {
  const char* name;
  std::function<void(Sound&)> make;
  const char* words;  // of the sentence
};

const std::vector<Forgery>& forgeries() {
  static const std::vector<Forgery> all{
      {"BoundsTooLarge", [](Sound& s) { s.manifest.bounds.hi.x += 1; },
       "manifest.json: its bounds are not those of the vertices"},
      {"BoundsTooSmall", [](Sound& s) { s.manifest.bounds.lo.z = std::nextafter(s.manifest.bounds.lo.z, 1.0); },
       "manifest.json: its bounds are not those of the vertices"},
      {"RubbishForAMaster", [](Sound& s) { s.write_master(std::as_bytes(std::span("rubbish"))); },
       "triangulation.pvtu: is not the master file of the tiles in the manifest"},
      {"AMasterOfFewerTiles",
       [](Sound& s) {
         Manifest fewer = s.manifest;
         fewer.tiles.pop_back();
         s.make_master(fewer);
       },
       "triangulation.pvtu: is not the master file of the tiles in the manifest"},
      {"AMasterOfTilesInAnotherOrder",
       [](Sound& s) {
         Manifest other = s.manifest;
         std::swap(other.tiles[0], other.tiles[1]);
         s.make_master(other);
       },
       "triangulation.pvtu: is not the master file of the tiles in the manifest"},
      {"ATileWithoutAttributes", [](Sound& s) { s.restore(s.meshes[1], {}); },
       "000001.vtu: has other attributes than the manifest says"},
      {"AnAttributeOfAnotherType",
       [](Sound& s) {
         s.restore(s.meshes[1], {true, {{"intensity", AttributeType::f32}}});
       },
       "000001.vtu: has other attributes than the manifest says"},
      {"NeighboursThatAreDenied",
       [](Sound& s) {
         s.manifest.neighbors = false;
         s.make_master(s.manifest);
       },
       "has neighbours, though the manifest says that it has none"},
      {"ATileThatIsNotListed", [](Sound& s) { fs::copy(tile_file(s.out, TileId{1}), tile_file(s.out, TileId{9})); },
       "000009.vtu: is not a tile of the manifest"},
      {"AnotherSize", [](Sound& s) { s.manifest.tiles[1].bytes += 7; }, "bytes, but the manifest says"},
      {"BoxesThatAreGone", [](Sound& s) { s.manifest.boxes.clear(); }, "the partition does not fit the result"},
      {"BoxesThatOverlap", [](Sound& s) { s.manifest.boxes[0].hi.x = std::numeric_limits<double>::infinity(); },
       "tile 0 has another box than the partition's splits make"},
      {"BoxesWithAGap", [](Sound& s) { s.manifest.boxes[1].hi.x = std::nextafter(s.manifest.boxes[1].hi.x, -1.0); },
       "tile 1 has another box than the partition's splits make"},
      {"ABoxThatEnds", [](Sound& s) { s.manifest.boxes[1].hi.z = 7; },
       "tile 1 has another box than the partition's splits make"},
      {"ARandomPartitionWithBoxes",
       [](Sound& s) {
         s.manifest.partition_kind = "random";
         s.manifest.partition = R"({"kind": "random", "dimension": 3, "tiles": 3, "splits": []})";
       },
       "tile 0 has another box than the partition's splits make"},
      {"SplitsOfAnotherKind", [](Sound& s) { s.manifest.partition_kind = "random"; },
       "manifest.json: partition: 2 splits do not make 3 tiles"},
      {"SplitsThatAreGone", [](Sound& s) { s.manifest.partition.clear(); }, "the partition has no splits"},
      {"SplitsThatLeadToEachOthersTiles",
       [](Sound& s) {  // the boxes part space, and hold their vertices: only tile_of() would be wrong
         std::string& text = s.manifest.partition;
         const auto first = text.find(", -1, "), second = text.find(", -2, ");
         ASSERT_TRUE(first != std::string::npos && second != std::string::npos);
         text[first + 3] = '2';
         text[second + 3] = '1';
       },
       "tile 0 has another box than the partition's splits make"},
      {"ASplitThatMoved",
       [](Sound& s) {
         const auto digits = s.manifest.partition.find("[0, 0.") + 6;
         char& digit = s.manifest.partition.at(digits + 12);
         digit = digit == '5' ? '6' : '5';
       },
       "tile 0 has another box than the partition's splits make"},
      {"AnotherDigestOfATile",
       [](Sound& s) {
         s.manifest.tiles[1].digest->low ^= 1;
         s.manifest.digest->low ^= 1;
       },
       "it holds another triangulation than was stored"},
      {"AnotherDigest", [](Sound& s) { s.manifest.digest->high ^= 1; }, "is not the sum of the tiles', "},
      {"VerticesThatChangedNames",
       [](Sound& s) {  // consistent, for no other tile knows them: only the digest can tell
         TileMesh& mesh = s.meshes[1];
         std::vector<std::size_t> inner;
         for (std::size_t i = 0; i < mesh.ids.size(); ++i)
           if (std::count(s.meshes[0].ids.begin(), s.meshes[0].ids.end(), mesh.ids[i]) +
                   std::count(s.meshes[2].ids.begin(), s.meshes[2].ids.end(), mesh.ids[i]) ==
               0)
             inner.push_back(i);
         ASSERT_GE(inner.size(), 2u);
         std::swap(mesh.ids[inner[0]], mesh.ids[inner[1]]);
         s.restore(mesh, s.options);
       },
       "000001.vtu: its digest is "},
      {"ADigestOfATileThatIsGone", [](Sound& s) { s.manifest.tiles[1].digest.reset(); },
       "manifest.json: some of its tiles have a digest, and others have none"},
      {"DigestsOfAllTilesThatAreGone",
       [](Sound& s) {
         for (TileEntry& entry : s.manifest.tiles) entry.digest.reset();
       },
       "manifest.json: has a digest, though none of its tiles has one"},
      {"TheDigestThatIsGone", [](Sound& s) { s.manifest.digest.reset(); },
       "manifest.json: has no digest, though all of its tiles have one"},
      {"ForeignVerticesOfEachOthersTiles",
       [](Sound& s) {
         for (TileId& owner : s.meshes[1].owners) owner = TileId{2 - owner.value};  // 1 stays 1
         s.restore(s.meshes[1], s.options);
       },
       ", but by the partition it belongs to tile "},
      {"ForeignVerticesOfATileThatIsNone", [](Sound& s) { s.restore(with_foreign_owner(s.meshes[1], 7), s.options); },
       "has the owner 7, but by the partition it belongs to tile "},
      {"ForeignVerticesOfTheLastNumber",
       [](Sound& s) { s.restore(with_foreign_owner(s.meshes[1], ~std::uint32_t{0}), s.options); },
       "has the owner 4294967295, but by the partition it belongs to tile "},
      {"ARandomPartitionOfSlabs",
       [](Sound& s) {
         s.manifest.partition_kind = "random";
         s.manifest.partition = R"({"kind": "random", "dimension": 3, "tiles": 3, "splits": []})";
         s.manifest.boxes.assign(3, Box{});
       },
       ", but by the partition it belongs to tile "},
      {"CountsThatComeAround", [](Sound& s) { s.manifest.invalid = s.manifest.filtered = std::uint64_t{1} << 63; },
       "9223372036854775808 filtered: they are more than there were"},
      {"DuplicatesWithoutAChecksum", [](Sound& s) { s.manifest.duplicates_xxh3 = 0; },
       "duplicates.bin: has no checksum in the manifest"},
      {"ALostPointHiddenInDuplicates",
       [](Sound& s) {
         s.write_duplicates({{300, 5}, {1'000'000'000, 3}});
         ++s.manifest.points_read;
       },
       "duplicates.bin: point 1000000000 is not one of the 302 points that were read"},
  };
  return all;
}

class Forged : public testing::TestWithParam<std::size_t> {};
INSTANTIATE_TEST_SUITE_P(Results, Forged, testing::Range(std::size_t{0}, forgeries().size()),
                         [](const auto& info) { return std::string(forgeries()[info.param].name); });

TEST_P(Forged, IsFoundThoughAllChecksumsAreRight) {
  const Forgery& forgery = forgeries()[GetParam()];
  Sound sound;
  const auto write_manifest = [&] {
    return write_whole(manifest_file(sound.out), store::manifest_to_text(sound.manifest));
  };
  ASSERT_TRUE(write_manifest());
  const auto before = verify(sound.out, {}, {});
  ASSERT_TRUE(before) << before.error().where;
  forgery.make(sound);
  ASSERT_TRUE(write_manifest());
  for (const bool against_cgal : {false, true}) {
    VerifyOptions options;
    options.against_cgal = against_cgal;
    const auto result = verify(sound.out, options, {});
    ASSERT_FALSE(result);
    EXPECT_NE(result.error().where.find(forgery.words), std::string::npos) << result.error().where;
    EXPECT_NE(result.error().where.find(sound.out.string()), std::string::npos) << result.error().where;
  }
}

// A vertex with all that belongs to it is moved to another tile: only its coordinates tell that it is there wrongly.
TEST(Verify, AVertexInAnotherTileThanItsHashSaysIsFound) {
  const auto points = sample_points(Shape::uniform, 3, 200);
  const auto partition = Partition::build_tiles(PartitionKind::random, 3, points, {}, 3);
  for (const std::size_t moved : {points.size(), std::size_t{17}}) {
    const auto meshes = sample_tiles(
        points, 3, 3, [&](std::size_t i) { return (partition.tile_of(points[i]).value + (i == moved ? 1 : 0)) % 3; });
    if (moved == points.size()) {
      const auto sound = verify_meshes(meshes);
      EXPECT_TRUE(sound) << sound.error().where;
    } else {
      expect_wrong(meshes, "vertex 17 has the owner ");
    }
  }
}

TEST(Verify, OfAResultWithoutDigestsSaysNothingAboutThem) {
  Sound sound;
  for (auto& entry : sound.manifest.tiles) entry.digest.reset();
  sound.manifest.digest.reset();
  ASSERT_TRUE(write_whole(manifest_file(sound.out), store::manifest_to_text(sound.manifest)));
  const auto result = verify(sound.out, {}, {});
  ASSERT_TRUE(result) << result.error().where;
  for (const auto& line : result.value().passed) EXPECT_EQ(line.find("digest"), std::string::npos) << line;
}

}  // namespace
}  // namespace tessera::test
