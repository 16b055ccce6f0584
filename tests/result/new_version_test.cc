#include "src/result/new_version.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <optional>
#include <set>
#include <span>
#include <string>

#include "src/base/files/checksum.h"
#include "src/base/files/names.h"
#include "src/base/files/whole_file.h"
#include "src/result/store/manifest.h"
#include "src/result/store/points_file.h"
#include "src/result/verify/verify.h"
#include "tests/store/sample_result.h"

namespace tessera::test {
namespace {

namespace fs = std::filesystem;

ResultColumn column(const std::string& name, bool of_cells) {
  ResultColumn made;
  made.name = name;
  made.of_cells = of_cells;
  made.type = AttributeType::u32;
  return made;
}

class Versions : public testing::Test {
 protected:
  Versions() {
    StoreOptions options;
    options.schema = {{"intensity", AttributeType::u16}};
    store_sample(out_, meshes_, options);
  }

  // Of one value everywhere, of cells and of vertices.
  void add(const std::string& name, std::uint32_t value) {
    const auto next = NewVersion::begin(out_);
    ASSERT_TRUE(next) << next.error().where;
    NewVersion& version = *next.value();
    for (std::size_t i = 0; i < version.source().tiles(); ++i) {
      const TileEntry& entry = version.source().entry(i);
      const std::vector<std::uint32_t> of_cells(entry.cells, value), of_vertices(entry.points, value + 1);
      const store::ColumnValues columns[] = {
          {true, {name, AttributeType::u32}, std::as_bytes(std::span(of_cells))},
          {false, {name + "_v", AttributeType::u32}, std::as_bytes(std::span(of_vertices))}};
      const auto added = version.add_columns(i, columns, {});
      ASSERT_TRUE(added) << added.error().where;
    }
    const auto done = version.commit({column(name, true), column(name + "_v", false)});
    ASSERT_TRUE(done) << done.error().where;
  }

  // "" or what is wrong with what a source reads.
  std::string wrong(const TileSource& source, std::size_t columns) const {
    if (source.manifest().columns.size() != 2 * columns) return "other columns";
    for (std::size_t i = 0; i < source.tiles(); ++i) {
      const auto tile = source.read(i, {.rows = true, .cell_columns = true});
      if (!tile) return tile.error().where;
      if (tile.value().mesh.cells != meshes_[i].cells || tile.value().mesh.ids != meshes_[i].ids) return "other cells";
      if (tile.value().cell_columns.size() != columns) return "other columns of cells";
      for (std::size_t c = 0; c < columns; ++c) {
        std::uint32_t value = 0;
        std::memcpy(&value, tile.value().cell_columns[c].data(), sizeof value);
        if (value != 100 * (c + 1)) return "another value";
        std::memcpy(&value, tile.value().rows.data() + 2 + 4 * c, sizeof value);
        if (value != 100 * (c + 1) + 1) return "another value of a vertex";
      }
    }
    return "";
  }

  std::string verified() const {
    const auto report = verify(out_, {}, {});
    return report ? "" : report.error().where;
  }

  std::set<std::string> files() const {
    std::set<std::string> names;
    for (const auto& file : fs::recursive_directory_iterator(out_))
      if (file.is_regular_file()) names.insert(fs::relative(file.path(), out_).string());
    return names;
  }

  const std::vector<TileMesh> meshes_ = sample_tiles(sample_points(Shape::uniform, 3, 300), 3, 2);
  const TemporaryFolder folder_;
  const fs::path out_ = folder_.path() / "out";
};

TEST_F(Versions, AReaderKeepsItsVersionWhileTwoMoreAreWritten) {
  const auto first = TileSource::open(out_).value();
  add("a", 100);
  const auto second = TileSource::open(out_).value();
  add("b", 200);
  EXPECT_EQ(wrong(first, 0), "");
  EXPECT_EQ(wrong(second, 1), "");
  EXPECT_EQ(wrong(TileSource::open(out_).value(), 2), "");
  EXPECT_EQ(verified(), "");
}

TEST_F(Versions, AReaderInAnotherProcessKeepsItsVersion) {
  int ready[2], go[2];
  ASSERT_EQ(::pipe2(ready, O_CLOEXEC), 0);
  ASSERT_EQ(::pipe2(go, O_CLOEXEC), 0);
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  char byte = 0;
  if (child == 0) {
    const auto source = TileSource::open(out_).value();
    if (::write(ready[1], &byte, 1) != 1 || ::read(go[0], &byte, 1) != 1) ::_exit(2);
    ::_exit(wrong(source, 0).empty() ? 0 : 1);
  }
  ASSERT_EQ(::read(ready[0], &byte, 1), 1);
  add("a", 100);
  add("b", 200);
  EXPECT_TRUE(files().contains("tiles/000000.vtu"));
  ASSERT_EQ(::write(go[1], &byte, 1), 1);
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  add("c", 300);
  EXPECT_FALSE(files().contains("tiles/000000.vtu")) << "its reader is gone";
  EXPECT_FALSE(files().contains("tiles/000000-2.vtu")) << "nobody reads version 2";
  EXPECT_EQ(wrong(TileSource::open(out_).value(), 3), "");
  EXPECT_EQ(verified(), "");
}

TEST_F(Versions, WhatNobodyReadsGoesWithTheNextWriterAndNotBefore) {
  add("a", 100);
  EXPECT_EQ(files(),
            (std::set<std::string>{".versions/000001.json", "manifest.json", "tiles/000000-2.vtu", "tiles/000000.vtu",
                                   "tiles/000001-2.vtu", "tiles/000001.vtu", "triangulation.pvtu"}));
  add("b", 200);
  EXPECT_EQ(files(),
            (std::set<std::string>{".versions/000002.json", "manifest.json", "tiles/000000-2.vtu", "tiles/000000-3.vtu",
                                   "tiles/000001-2.vtu", "tiles/000001-3.vtu", "triangulation.pvtu"}));
}

TEST_F(Versions, WhatIsNotCommittedLeavesNothing) {
  const auto before = files();
  {
    const auto next = NewVersion::begin(out_);
    ASSERT_TRUE(next) << next.error().where;
    const TileEntry& entry = next.value()->source().entry(0);
    const std::vector<std::uint32_t> values(entry.cells, 7);
    const store::ColumnValues columns[] = {{true, {"a", AttributeType::u32}, std::as_bytes(std::span(values))}};
    ASSERT_TRUE(next.value()->add_columns(0, columns, {}));
    EXPECT_FALSE(next.value()->commit({column("a", true)}));
  }
  EXPECT_EQ(files(), before);
  EXPECT_EQ(verified(), "");
}

TEST_F(Versions, WithoutRoomForOneAllIsAsItWas) {
  const auto before = files();
  const ResultColumn columns[] = {column("a", true), column("a_v", false)};
  const auto bytes_of_tiles = [](const Manifest& manifest) {
    std::uint64_t bytes = 0;
    for (const auto& entry : manifest.tiles) bytes += entry.bytes;
    return bytes;
  };
  const auto of_new_version = [&](std::uint64_t beside, std::optional<std::uint64_t> free) -> Status {
    BOOST_OUTCOME_TRY(next, NewVersion::begin(out_));
    return next->check_room(columns, beside, free);
  };
  const auto first = TileSource::open(out_).value().manifest();
  const auto refused = of_new_version(0, bytes_of_tiles(first));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Errc::io);
  EXPECT_EQ(refused.error().where, out_.string() + ": a new version, beside the one that stands, needs up to 1 MiB, " +
                                       "and the disk has 0 MiB left");
  EXPECT_EQ(files(), before);
  // With half as much again, and some for each tile, there is room; not when that is needed for something else.
  const std::uint64_t enough = bytes_of_tiles(first) * 3 / 2 + (64 << 10);
  EXPECT_TRUE(of_new_version(0, enough));
  EXPECT_TRUE(of_new_version(enough, std::nullopt)) << "nobody can tell";
  EXPECT_FALSE(of_new_version(enough, enough));
  add("a", 100);
  // What it took was not too little.
  const auto second = TileSource::open(out_).value().manifest();
  fs::remove_all(out_);
  store_sample(out_, meshes_, {.schema = first.schema});
  EXPECT_FALSE(of_new_version(0, bytes_of_tiles(second) + fs::file_size(manifest_file(out_))));
}

TEST_F(Versions, TilesThatAreKeptAsPointsGetColumnsToo) {
  fs::remove_all(out_);
  store_sample(out_, meshes_, {.schema = {{"intensity", AttributeType::u16}}}, {}, {},
               [](TileId tile) { return tile.value == 0 ? TileKind::points : TileKind::cells; });
  const auto first = TileSource::open(out_).value();
  const auto without = first.read(0, {.rows = true, .cell_columns = true}).value();
  EXPECT_EQ(without.rows.size(), without.mesh.points.size() * 2);
  add("a", 100);
  add("b", 200);
  EXPECT_EQ(files(),
            (std::set<std::string>{".versions/000001.json", ".versions/000002.json", "manifest.json",
                                   "tiles/000000-2.pts", "tiles/000000-3.pts", "tiles/000000.pts", "tiles/000001-2.vtu",
                                   "tiles/000001-3.vtu", "tiles/000001.vtu", "triangulation.pvtu"}));
  const auto tile = TileSource::open(out_).value().read(0, {.rows = true, .cell_columns = true}).value();
  EXPECT_EQ(tile.mesh.cells, without.mesh.cells);
  ASSERT_EQ(tile.cell_columns.size(), 2u);
  const std::size_t vertices = tile.mesh.points.size(), cells = tile.mesh.cell_ghost.size();
  ASSERT_EQ(tile.rows.size(), vertices * 10);
  for (std::uint32_t c = 0; c < 2; ++c) {
    const std::vector<std::uint32_t> of_cells(cells, 100 * (c + 1));
    EXPECT_TRUE(std::ranges::equal(tile.cell_columns[c], std::as_bytes(std::span(of_cells))));
    for (std::size_t v = 0; v < vertices; ++v) {
      std::uint32_t value = 0;
      std::memcpy(&value, &tile.rows[v * 10 + 2 + 4 * c], sizeof value);
      ASSERT_EQ(value, 100 * (c + 1) + 1);
      ASSERT_EQ(std::memcmp(&tile.rows[v * 10], &without.rows[v * 2], 2), 0);
    }
  }
  EXPECT_EQ(first.read(0, {.rows = true}).value().rows, without.rows) << "a reader keeps its version";
  EXPECT_EQ(verified(), "");
}

// Also where the checksum of the file does not tell.
TEST_F(Versions, ADamagedColumnOfATileKeptAsPointsIsToldWithItsPlace) {
  fs::remove_all(out_);
  store_sample(out_, meshes_, {}, {}, {}, [](TileId) { return TileKind::points; });
  add("a", 100);
  auto manifest = TileSource::open(out_).value().manifest();
  const auto path = tile_file(out_, manifest.tiles[0]);
  const auto good = read_whole(path).value();
  const auto head = read_points_head(path, TileId{0}).value();
  for (const auto& column : head.columns()) {
    if (column.what != store::PointsColumn::What::named) continue;
    std::uint64_t at = head.bytes();
    for (std::uint64_t i = 0; i < column.first_block; ++i) at += head.blocks[i].bytes;
    auto bad = good;
    bad[at] ^= std::byte{1};
    ASSERT_TRUE(write_whole(path, bad));
    manifest.tiles[0].xxh3 = checksum_file(path, ChecksumOf::pieces).value();
    ASSERT_TRUE(write_whole(manifest_file(out_), store::manifest_to_text(manifest)));
    EXPECT_EQ(verified(), path.string() + ", " + head.place(column) + ", block 0: is damaged");
  }
}

TEST_F(Versions, TwoWritersAreOneTooMany) {
  const auto next = NewVersion::begin(out_);
  ASSERT_TRUE(next) << next.error().where;
  const auto other = NewVersion::begin(out_);
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error().code, Errc::usage);
}

TEST_F(Versions, TheMasterOfTheVersionBeforeIsAcceptedAndMended) {
  const auto old_master = read_whole(master_file(out_)).value();
  add("a", 100);
  const auto new_master = read_whole(master_file(out_)).value();
  ASSERT_NE(old_master, new_master);
  ASSERT_TRUE(write_whole(master_file(out_), old_master));
  EXPECT_EQ(verified(), "");
  {
    const auto next = NewVersion::begin(out_);
    ASSERT_TRUE(next) << next.error().where;
  }
  EXPECT_EQ(read_whole(master_file(out_)).value(), new_master);
  EXPECT_EQ(verified(), "");
  // Its tiles are gone by now.
  ASSERT_TRUE(write_whole(master_file(out_), old_master));
  EXPECT_NE(verified().find("triangulation.pvtu: is the master file of the version before"), std::string::npos)
      << verified();
}

TEST_F(Versions, WithoutSecondNamesForFilesACopyIsKeptAndNothingIsRemoved) {
  add("a", 100);
  fs::remove(version_file(out_, 1));
  fs::copy_file(manifest_file(out_), version_copy(out_, 1));  // its tiles are those of version 2
  add("b", 200);
  EXPECT_TRUE(files().contains("tiles/000000-2.vtu"));
  add("c", 300);
  EXPECT_TRUE(files().contains("tiles/000000-2.vtu")) << "nobody can tell whether it is read";
  EXPECT_TRUE(files().contains(".versions/000001.copy.json"));
  EXPECT_EQ(verified(), "");
}

TEST_F(Versions, AStrangeTileFileIsDamageStill) {
  add("a", 100);
  fs::copy_file(out_ / "tiles/000000.vtu", out_ / "tiles/000007.vtu");
  EXPECT_NE(verified().find("000007.vtu: is not a tile of the manifest"), std::string::npos) << verified();
}

}  // namespace
}  // namespace tessera::test
