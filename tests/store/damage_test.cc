// Tile files that something happened to: corrupt, and the sentence names the place.
#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <functional>
#include <string>

#include "src/base/files/names.h"
#include "src/base/files/whole_file.h"
#include "src/result/store/packed_array.h"
#include "src/result/store/tile_store.h"
#include "src/result/store/vtk_xml.h"
#include "tests/store/sample_result.h"

namespace tessera::test {
namespace {

namespace fs = std::filesystem;

// A tile of a triangulation in two tiles, with attributes, and its file.
class DamagedTile : public testing::TestWithParam<int> {
 protected:
  DamagedTile() : mesh_(sample_tiles(sample_points(Shape::uniform, GetParam(), 40), GetParam(), 2)[1]) {
    options_.schema = {{"intensity", AttributeType::u16}};
    good_ = store(mesh_);
  }

  std::vector<std::byte> store(const TileMesh& mesh) {
    const std::vector<std::byte> rows(mesh.points.size() * 2, std::byte{3});
    EXPECT_TRUE(write_tile(folder_.path(), TileId{1}, mesh, rows, options_));
    EXPECT_TRUE(stored_tiles(folder_.path()));
    return read_whole(path()).value();
  }
  fs::path path() const { return tile_file(folder_.path(), TileId{1}); }
  void write(std::span<const std::byte> bytes) const {
    std::ofstream(path(), std::ios::binary | std::ios::trunc)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  }
  Result<StoredTile> read() const { return read_tile(folder_.path(), TileId{1}, true); }
  void expect_corrupt(const std::string& says) const {
    const auto tile = read();
    ASSERT_FALSE(tile) << says;
    EXPECT_EQ(tile.error().code, Errc::corrupt) << tile.error().where;
    EXPECT_NE(tile.error().where.find("000001.vtu, " + says), std::string::npos) << tile.error().where;
  }
  // The file with the first occurrence of a text in its header replaced.
  void replace(const std::string& from, const std::string& to) const {
    std::string text(as_text(good_));
    ASSERT_NE(text.find(from), std::string::npos) << from;
    text.replace(text.find(from), from.size(), to);
    write(std::as_bytes(std::span(text)));
  }

  TemporaryFolder folder_;
  StoreOptions options_;
  TileMesh mesh_;
  std::vector<std::byte> good_;
};
INSTANTIATE_TEST_SUITE_P(Dimensions, DamagedTile, testing::Values(2, 3));

TEST_P(DamagedTile, IsCorruptWhereverItIsCutOff) {
  ASSERT_TRUE(read());
  for (std::size_t size = good_.size(); size-- > 0;) {
    fs::resize_file(path(), size);
    const auto tile = read();
    ASSERT_FALSE(tile) << size;
    ASSERT_EQ(tile.error().code, Errc::corrupt) << size;
  }
}

// Coordinates, ids and attributes included. A few bits of deflated blocks mean nothing, as lengths of codes that do not
// occur: then the tile is what it was.
TEST_P(DamagedTile, IsCorruptOrTheSameWhicheverByteIsChanged) {
  std::size_t same = 0;
  for (std::size_t at = 0; at < good_.size(); ++at) {
    auto bad = good_;
    bad[at] ^= std::byte{1} << (at * 5 % 8);
    write(bad);
    const auto tile = read();
    if (!tile) {
      ASSERT_EQ(tile.error().code, Errc::corrupt) << at;
      continue;
    }
    ++same;
    ASSERT_EQ(tile.value().mesh.points, mesh_.points) << at;
    ASSERT_EQ(tile.value().mesh.ids, mesh_.ids) << at;
    ASSERT_EQ(tile.value().mesh.owners, mesh_.owners) << at;
    ASSERT_EQ(tile.value().mesh.cells, mesh_.cells) << at;
    ASSERT_EQ(tile.value().mesh.cell_ghost, mesh_.cell_ghost) << at;
    ASSERT_EQ(tile.value().mesh.neighbors, mesh_.neighbors) << at;
    ASSERT_EQ(tile.value().rows, std::vector<std::byte>(mesh_.points.size() * 2, std::byte{3})) << at;
  }
  EXPECT_LT(same, good_.size() / 100);
}

TEST_P(DamagedTile, IsCorruptWithAHeaderThatIsNotOurs) {
  replace("tile 1 ", "tile 2 ");
  expect_corrupt("header: is that of tile 2");
  for (const auto& [from, to] :
       std::vector<std::pair<std::string, std::string>>{{"format 3", "format 5"},
                                                        {"dimension " + std::to_string(GetParam()), "dimension 4"},
                                                        {"version=\"1.0\" byte", "version=\"1.1\" byte"},
                                                        {"NumberOfPoints=\"", "NumberOfPoints=\"0"},
                                                        {"NumberOfPoints=\"", "NumberOfPoints=\"-"},
                                                        {"NumberOfCells=\"", "NumberOfCells=\"99999999999999999999"},
                                                        {"Name=\"intensity\"", "Name=\"owner\""},
                                                        {"Name=\"intensity\"", "Name=\"\""},
                                                        {"Name=\"intensity\"", "Name=\"a<b\""},
                                                        {"type=\"UInt16\"", "type=\"UInt17\""},
                                                        {"<CellData>", "<CellData >"},
                                                        {"Name=\"types\"", "Name=\"typen\""}}) {
    replace(from, to);
    expect_corrupt("header: is damaged, or not that of a tile file");
  }
}

TEST_P(DamagedTile, IsCorruptWhenItTellsOfMoreThanItHolds) {
  const std::string points = "NumberOfPoints=\"" + std::to_string(mesh_.points.size());
  for (const char* more : {"0", "00000", "0000000000", "000000000000000"}) {
    replace(points, points + more);
    const auto tile = read();
    ASSERT_FALSE(tile);
    EXPECT_EQ(tile.error().code, Errc::corrupt);
  }
  replace("offset=\"0\"", "offset=\"8\"");
  expect_corrupt("Points: its table of blocks is damaged");
  auto longer = good_;
  longer.push_back(std::byte{10});
  write(longer);
  expect_corrupt("end: is not where the arrays end");
}

TEST_P(DamagedTile, IsCorruptWithValuesThatCannotBe) {
  const auto expect = [&](const std::function<void(TileMesh&)>& change, const std::string& says) {
    TileMesh mesh = mesh_;
    change(mesh);
    store(mesh);
    expect_corrupt(says);
  };
  const auto n = static_cast<std::int32_t>(mesh_.points.size());
  const auto m = static_cast<std::int32_t>(mesh_.cell_ghost.size());
  const int corners = GetParam() + 1;
  expect([&](TileMesh& mesh) { mesh.points[2].x = std::numeric_limits<double>::infinity(); }, "Points: point 2 is not");
  expect([&](TileMesh& mesh) { mesh.cells[corners] = n; }, "Cells/connectivity: cell 1 has vertex ");
  expect([&](TileMesh& mesh) { mesh.cells[corners] = -1; }, "Cells/connectivity: cell 1 has vertex ");
  expect([&](TileMesh& mesh) { mesh.cells[1] = mesh.cells[0]; },
         "Cells/connectivity: cell 0 has the same vertex twice");
  expect([&](TileMesh& mesh) { mesh.neighbors[1] = m; }, "CellData/neighbors: cell 0 has neighbour ");
  expect([&](TileMesh& mesh) { mesh.cell_ghost[1] = 2; }, "CellData/vtkGhostType: cell 1 is neither 0 nor 1");
  expect([&](TileMesh& mesh) { mesh.point_ghost[1] = 2; }, "PointData/vtkGhostType: point 1 is neither 0 nor 1");
  expect([&](TileMesh& mesh) { mesh.owners[1] = {0}; },
         "PointData/owner: point 1 of tile 0 has the wrong vtkGhostType");
  expect([&](TileMesh& mesh) { mesh.owners.back() = {1}; }, "PointData/owner: point ");
}

TEST_P(DamagedTile, IsCorruptUnderAnotherNumber) {
  fs::rename(path(), tile_file(folder_.path(), TileId{5}));
  const auto tile = read_tile(folder_.path(), TileId{5});
  ASSERT_FALSE(tile);
  EXPECT_EQ(tile.error().code, Errc::corrupt);
  EXPECT_NE(tile.error().where.find("000005.vtu, header: is that of tile 1"), std::string::npos) << tile.error().where;
}

}  // namespace
}  // namespace tessera::test
