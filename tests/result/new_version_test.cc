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
#include "src/result/version_log.h"
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
    const auto next = NewVersion::begin(out_, {.lock = {}, .keep = keep_});
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
  std::optional<std::uint32_t> keep_;
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
  EXPECT_EQ(files(), (std::set<std::string>{".versions/000001.json", ".versions/log.json", "manifest.json",
                                            "tiles/000000-2.vtu", "tiles/000000.vtu", "tiles/000001-2.vtu",
                                            "tiles/000001.vtu", "triangulation.pvtu"}));
  add("b", 200);
  EXPECT_EQ(files(), (std::set<std::string>{".versions/000002.json", ".versions/log.json", "manifest.json",
                                            "tiles/000000-2.vtu", "tiles/000000-3.vtu", "tiles/000001-2.vtu",
                                            "tiles/000001-3.vtu", "triangulation.pvtu"}));
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
  EXPECT_EQ(files(), (std::set<std::string>{".versions/000001.json", ".versions/000002.json", ".versions/log.json",
                                            "manifest.json", "tiles/000000-2.pts", "tiles/000000-3.pts",
                                            "tiles/000000.pts", "tiles/000001-2.vtu", "tiles/000001-3.vtu",
                                            "tiles/000001.vtu", "triangulation.pvtu"}));
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
    const auto other = NewVersion::begin(out_);  // which has mended it
    ASSERT_TRUE(other) << other.error().where;
    EXPECT_TRUE(mend_master(out_)) << "needs no lock";
    ASSERT_TRUE(write_whole(master_file(out_), old_master));
    EXPECT_EQ(mend_master(out_).error().code, Errc::usage);
  }
  ASSERT_TRUE(mend_master(out_));
  EXPECT_EQ(read_whole(master_file(out_)).value(), new_master);
  ASSERT_TRUE(write_whole(master_file(out_), old_master));
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

TEST_F(Versions, AsManyStayReadableAsAreToBeKept) {
  const auto readable = [&] {
    std::set<std::uint32_t> numbers;
    for (std::uint32_t version = 1; version <= 8; ++version) {
      const auto source = TileSource::open(version_file(out_, version));
      if (!source) continue;
      EXPECT_EQ(source.value().manifest().version, version);
      EXPECT_EQ(source.value().folder(), out_);
      EXPECT_EQ(wrong(source.value(), version - 1), "");
      numbers.insert(version);
    }
    return numbers;
  };
  keep_ = 3;
  add("a", 100);
  add("b", 200);
  keep_.reset();  // the result remembers it
  add("c", 300);
  add("d", 400);
  EXPECT_EQ(readable(), (std::set<std::uint32_t>{2, 3, 4, 5}));
  add("e", 500);
  EXPECT_EQ(readable(), (std::set<std::uint32_t>{3, 4, 5, 6}));
  EXPECT_EQ(verified(), "");
  EXPECT_TRUE(verify(version_file(out_, 3), {}, {}));
  const auto gone = TileSource::open(version_file(out_, 2));
  ASSERT_FALSE(gone);
  EXPECT_EQ(gone.error().code, Errc::usage);
  EXPECT_EQ(gone.error().where,
            out_.string() + ": version 2 is not kept any more; the versions 3, 4, 5 and 6 can be read");
  const auto never = TileSource::open(version_file(out_, 7));
  ASSERT_FALSE(never);
  EXPECT_EQ(never.error().where, out_.string() + ": version 7 does not exist; the versions 3, 4, 5 and 6 can be read");
  keep_ = 1;
  add("f", 600);
  EXPECT_EQ(readable(), (std::set<std::uint32_t>{6, 7}));
  const auto old = NewVersion::begin(version_file(out_, 6));
  ASSERT_FALSE(old);
  EXPECT_EQ(old.error().code, Errc::usage);
}

TEST_F(Versions, TilesComeAndGoAndDuplicatesAreThoseOfTheVersion) {
  const std::vector<DuplicatePair> first{{5000, 1}}, second{{5000, 1}, {5001, 2}};
  const auto change = [&](const std::vector<DuplicatePair>& pairs, bool with_tile) {
    const auto begun = NewVersion::begin(out_, {.lock = {}, .keep = 9});
    ASSERT_TRUE(begun) << begun.error().where;
    NewVersion& next = *begun.value();
    next.manifest().points_read = 6000;
    ASSERT_TRUE(next.replace_duplicates(pairs));
    if (with_tile) {
      const std::vector<std::byte> rows(meshes_[1].points.size() * 2);
      const auto entry = write_tile(next.scratch(), TileId{1}, meshes_[1], rows, {.schema = next.manifest().schema});
      ASSERT_TRUE(entry) << entry.error().where;
      ASSERT_TRUE(next.add_tile(entry.value(), tile_file(next.scratch(), entry.value())));
    } else {
      next.remove_tile(1);
    }
    ASSERT_TRUE(next.commit({}, {.added = 7, .removed = 3, .inputs = {}, .command = {"tessera", "update"}}));
  };
  change(first, false);
  change(second, true);
  change({}, false);
  const auto at = [&](std::uint32_t version) { return TileSource::open(version_file(out_, version)).value(); };
  EXPECT_EQ(at(1).tiles(), 2u);
  EXPECT_EQ(at(2).tiles(), 1u);
  EXPECT_EQ(at(3).tiles(), 2u);
  EXPECT_EQ(at(4).tiles(), 1u);
  EXPECT_EQ(at(3).manifest().digest, at(1).manifest().digest);
  EXPECT_EQ(at(3).manifest().cells, at(1).manifest().cells);
  EXPECT_NE(at(2).manifest().digest, at(1).manifest().digest);
  EXPECT_EQ(at(2).manifest().vertices, at(1).entry(0).own_points);
  EXPECT_EQ(at(2).manifest().format_version, updated_format);
  const auto duplicates = [&](std::uint32_t version) { return read_duplicates(out_, at(version).manifest()).value(); };
  EXPECT_EQ(duplicates(1), std::vector<DuplicatePair>{});
  EXPECT_EQ(duplicates(2), first);
  EXPECT_EQ(duplicates(3), second);
  EXPECT_EQ(duplicates(4), std::vector<DuplicatePair>{});

  const auto told = tell_versions(out_).value();
  ASSERT_EQ(told.versions.size(), 4u);
  EXPECT_EQ(told.keep, 9u);
  const VersionEntry& entry = told.versions[2].entry;
  EXPECT_TRUE(told.versions[2].readable);
  EXPECT_EQ(entry.added, 7u);
  EXPECT_EQ(entry.removed, 3u);
  EXPECT_EQ(entry.tiles_written, 1u);
  EXPECT_EQ(entry.digest, at(3).manifest().digest);
  EXPECT_EQ(entry.command, (std::vector<std::string>{"tessera", "update"}));
  EXPECT_EQ(told.versions[0].entry.vertices, at(1).manifest().vertices);
}

TEST(VersionLog, IsBoundedAndReadAsItWasWritten) {
  const TemporaryFolder folder;
  VersionLog log{.keep = 4, .versions = {}};
  for (std::uint32_t version = 1; version <= 1500; ++version) {
    const std::size_t words = version == 1499 ? 1000 : 2;
    append(log, {.version = version,
                 .inputs = std::vector<std::string>(words, std::string(10'000, 'x')),
                 .columns = {"area"},
                 .digest = Digest{},
                 .command = std::vector<std::string>(words, std::string(10'000, '"')),
                 .software_version = "1"});
  }
  EXPECT_EQ(log.versions.size(), 1000u);
  EXPECT_LT(version_log_text(log).size(), 2u << 20);
  ASSERT_TRUE(make_directories(versions_folder(folder.path())));
  ASSERT_TRUE(write_whole(version_log_file(folder.path()), version_log_text(log)));
  const auto read = read_version_log(folder.path(), 1500);
  ASSERT_TRUE(read) << read.error().where;
  EXPECT_EQ(read.value().keep, 4u);
  EXPECT_EQ(read.value().versions, log.versions);
  EXPECT_EQ(read_version_log(folder.path(), 1490).value().versions.back().version, 1490u) << "the rest was left";
  for (const char* damaged : {"", "[]", "{}", R"({"keep":0,"versions":[]})", R"({"keep":1,"versions":[{}]})"}) {
    ASSERT_TRUE(write_whole(version_log_file(folder.path()), damaged));
    const auto refused = read_version_log(folder.path(), 1500);
    ASSERT_FALSE(refused) << damaged;
    EXPECT_EQ(refused.error().code, Errc::corrupt);
  }
}

TEST_F(Versions, AStrangeTileFileIsDamageStill) {
  add("a", 100);
  fs::copy_file(out_ / "tiles/000000.vtu", out_ / "tiles/000007.vtu");
  EXPECT_NE(verified().find("000007.vtu: is not a tile of the manifest"), std::string::npos) << verified();
}

}  // namespace
}  // namespace tessera::test
