// Results that older versions wrote stay readable (tests/data/format-2), or say what can be done.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>

#include "src/base/files/checksum.h"
#include "src/base/files/names.h"
#include "src/base/files/whole_file.h"
#include "src/result/store/tile_store.h"
#include "tests/store/sample_result.h"

namespace tessera {
namespace {

using test::read_tile;

namespace fs = std::filesystem;

fs::path old_result(int format) { return fs::path(TESSERA_TEST_DATA) / ("format-" + std::to_string(format)); }

// Of points.csv, which it was made of, by row.
std::vector<std::pair<Point, double>> input() {
  std::ifstream file(old_result(2) / "points.csv");
  std::string line;
  std::getline(file, line);
  std::vector<std::pair<Point, double>> rows;
  for (std::pair<Point, double> row; std::getline(file, line); rows.push_back(row))
    EXPECT_EQ(std::sscanf(line.c_str(), "%lf,%lf,%lf,%lf", &row.first.x, &row.first.y, &row.first.z, &row.second), 4);
  return rows;
}

class OldFormat : public testing::TestWithParam<int> {
 protected:
  const fs::path result_ = old_result(GetParam());
};

TEST_P(OldFormat, TilesHoldTheInputsPointsAndAttributes) {
  const auto manifest = read_manifest(result_);
  ASSERT_TRUE(manifest) << manifest.error().where;
  EXPECT_EQ(manifest.value().format_version, GetParam());
  EXPECT_EQ(checksum_file(master_file(result_)).value(), manifest.value().master_xxh3);
  const auto rows = input();
  ASSERT_EQ(rows.size(), manifest.value().points_read);
  std::uint64_t own = 0, main = 0;
  for (const auto& entry : manifest.value().tiles) {
    const auto tile = read_tile(result_, entry.tile, true);
    ASSERT_TRUE(tile) << tile.error().where;
    const TileMesh& mesh = tile.value().mesh;
    EXPECT_EQ(mesh.owners.size(), mesh.points.size());
    const auto file = tile_file(result_, entry.tile);
    EXPECT_EQ(checksum_file(file, data_sum_of(GetParam())).value(), entry.xxh3);
    EXPECT_EQ(tile.value().schema, manifest.value().schema);
    for (std::size_t i = 0; i < mesh.points.size(); ++i) {
      EXPECT_EQ(mesh.points[i], rows.at(mesh.ids[i].value).first);
      double intensity = 0;
      std::memcpy(&intensity, tile.value().rows.data() + 8 * i, 8);
      EXPECT_EQ(intensity, rows.at(mesh.ids[i].value).second);
    }
    own += static_cast<std::uint64_t>(std::count(mesh.point_ghost.begin(), mesh.point_ghost.end(), 0));
    main += static_cast<std::uint64_t>(std::count(mesh.cell_ghost.begin(), mesh.cell_ghost.end(), 0));
    const auto vertices = store::read_tile(tile_file(result_, entry), entry.tile, {.cells = false});
    ASSERT_TRUE(vertices) << vertices.error().where;
    EXPECT_EQ(vertices.value().mesh.points, mesh.points);
    EXPECT_TRUE(vertices.value().mesh.cells.empty());
  }
  EXPECT_EQ(own, manifest.value().vertices);
  EXPECT_EQ(main, manifest.value().cells);
}

TEST_P(OldFormat, EveryTruncationIsCorruptAndNeverACrash) {
  const test::TemporaryFolder folder;
  fs::create_directories(tiles_folder(folder.path()));
  const auto path = tile_file(folder.path(), TileId{0});
  fs::copy_file(tile_file(result_, TileId{0}), path);
  ASSERT_TRUE(read_tile(folder.path(), TileId{0}));
  for (auto size = fs::file_size(path); size > 0; size -= std::min<std::uintmax_t>(size, 53)) {
    fs::resize_file(path, size - 1);
    const auto read = read_tile(folder.path(), TileId{0});
    ASSERT_FALSE(read) << size;
    EXPECT_EQ(read.error().code, Errc::corrupt) << size;
  }
}

TEST_P(OldFormat, NoFlippedBitIsACrash) {
  const test::TemporaryFolder folder;
  fs::create_directories(tiles_folder(folder.path()));
  const auto path = tile_file(folder.path(), TileId{0});
  const auto good = read_whole(tile_file(result_, TileId{0})).value();
  for (std::size_t at = 0; at < good.size(); at += 3) {
    auto bad = good;
    bad[at] ^= std::byte{1} << (at / 3 % 8);
    ASSERT_TRUE(write_whole(path, bad));
    const auto read = read_tile(folder.path(), TileId{0}, true);  // coordinates and padding carry no checksum
    if (!read) {
      EXPECT_EQ(read.error().code, Errc::corrupt) << at;
    }
  }
}

TEST(Format2, HasNoGapsBetweenArrays) {
  const test::TemporaryFolder folder;
  fs::create_directories(tiles_folder(folder.path()));
  const auto bytes = read_whole(tile_file(old_result(2), TileId{0})).value();
  std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const auto replace = [&](const std::string& from, const std::string& to) {
    const auto at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
  };
  // The last array is moved by a byte, which format 3 allows.
  const auto offset = text.substr(0, text.find("AppendedData")).rfind("offset=\"") + 8;
  const std::string number = text.substr(offset, text.find('"', offset) - offset);
  const auto begin = text.find("_", text.find("<AppendedData")) + 1;
  text.insert(begin + std::stoul(number), 1, '\0');
  replace("offset=\"" + number + "\"", "offset=\"" + std::to_string(std::stoul(number) + 1) + "\"");
  const auto path = tile_file(folder.path(), TileId{0});
  ASSERT_TRUE(write_whole(path, text));
  const auto read = read_tile(folder.path(), TileId{0});
  ASSERT_FALSE(read);
  EXPECT_NE(read.error().where.find("header: its arrays overlap or leave gaps"), std::string::npos)
      << read.error().where;
  replace("format 2", "format 3");
  ASSERT_TRUE(write_whole(path, text));
  EXPECT_TRUE(read_tile(folder.path(), TileId{0}));
}

// Its tiles were HDF5 files, whose library reads what a stranger's file tells it to.
TEST(Format1, IsRefusedWithWhatCanBeDone) {
  const test::TemporaryFolder folder;
  ASSERT_TRUE(
      write_whole(manifest_file(folder.path()),
                  std::string_view(R"({"format": "tessera", "format_version": 1, "software_version": "0.1.0"})")));
  const auto read = read_manifest(folder.path());
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().code, Errc::corrupt);
  EXPECT_EQ(read.error().where, manifest_file(folder.path()).string() +
                                    ": is of format version 1, which this program no longer reads: use the tessera "
                                    "that wrote it (software_version in "
                                    "this file) to export it, or triangulate again; the file names inputs and command");
}

INSTANTIATE_TEST_SUITE_P(Formats, OldFormat, testing::Values(2));

}  // namespace
}  // namespace tessera
