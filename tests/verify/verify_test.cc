#include "src/verify/verify.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <functional>
#include <set>

#include "src/kernel/kernel.h"
#include "tests/store/sample_result.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using test::sample_points;
using test::sample_tiles;
using test::Shape;
using test::store_sample;
using test::TemporaryFolder;
using Meshes = std::vector<TileMesh>;

std::size_t corners(const TileMesh& mesh) { return static_cast<std::size_t>(mesh.dimension) + 1; }
std::size_t vertex(const TileMesh& mesh, std::size_t cell, std::size_t k) {
  return static_cast<std::size_t>(mesh.cells[cell * corners(mesh) + k]);
}

std::set<std::uint64_t> ids_of(const TileMesh& mesh, std::size_t cell) {
  std::set<std::uint64_t> ids;
  for (std::size_t k = 0; k < corners(mesh); ++k) ids.insert(mesh.ids[vertex(mesh, cell, k)]);
  return ids;
}

// Takes a cell away from every tile, or from the given one alone; its neighbours then have the outside there.
void remove_cell(Meshes& meshes, const std::set<std::uint64_t>& ids, int only_tile = -1) {
  for (std::size_t tile = 0; tile < meshes.size(); ++tile) {
    if (only_tile >= 0 && tile != static_cast<std::size_t>(only_tile)) continue;
    TileMesh& mesh = meshes[tile];
    const std::size_t n = corners(mesh);
    for (std::size_t c = 0; c < mesh.cell_ghost.size(); ++c) {
      if (ids_of(mesh, c) != ids) continue;
      const auto at = static_cast<std::ptrdiff_t>(c * n);
      mesh.cells.erase(mesh.cells.begin() + at, mesh.cells.begin() + at + static_cast<std::ptrdiff_t>(n));
      mesh.neighbors.erase(mesh.neighbors.begin() + at, mesh.neighbors.begin() + at + static_cast<std::ptrdiff_t>(n));
      mesh.cell_ghost.erase(mesh.cell_ghost.begin() + static_cast<std::ptrdiff_t>(c));
      for (auto& neighbor : mesh.neighbors) {
        if (neighbor == static_cast<std::int32_t>(c)) {
          neighbor = -1;
        } else if (neighbor > static_cast<std::int32_t>(c)) {
          --neighbor;
        }
      }
      break;
    }
  }
}

// The first cell of tile 0 for which `wanted` holds.
std::size_t find_cell(const TileMesh& mesh, const std::function<bool(std::size_t)>& wanted) {
  for (std::size_t c = 0; c < mesh.cell_ghost.size(); ++c)
    if (wanted(c)) return c;
  ADD_FAILURE() << "no such cell";
  return 0;
}

bool all_own(const TileMesh& mesh, std::size_t cell) {
  for (std::size_t k = 0; k < corners(mesh); ++k)
    if (mesh.point_ghost[vertex(mesh, cell, k)] != 0) return false;
  return true;
}

bool on_hull(const TileMesh& mesh, std::size_t cell) {
  for (std::size_t k = 0; k < corners(mesh); ++k)
    if (mesh.neighbors[cell * corners(mesh) + k] == -1) return true;
  return false;
}

Result<VerifyReport> verify_meshes(const Meshes& meshes, bool neighbors = true) {
  const TemporaryFolder folder;
  StoreOptions options;
  options.neighbors = neighbors;
  store_sample(folder.path() / "out", meshes, options);
  return verify(folder.path() / "out", {}, {});
}

void expect_wrong(const Meshes& meshes, const std::string& words, bool neighbors = true) {
  const auto result = verify_meshes(meshes, neighbors);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, Errc::not_delaunay) << result.error().where;
  EXPECT_NE(result.error().where.find(words), std::string::npos) << result.error().where;
}

using Parameters = std::tuple<int, Shape, std::uint32_t, bool>;
class SoundResult : public testing::TestWithParam<Parameters> {};

TEST_P(SoundResult, Passes) {
  const auto [dimension, shape, tiles, neighbors] = GetParam();
  const auto points = sample_points(shape, dimension, 700);
  const auto meshes = sample_tiles(points, dimension, tiles);
  const TemporaryFolder folder;
  StoreOptions store;
  store.neighbors = neighbors;
  const auto manifest =
      store_sample(folder.path(), meshes, store, {{points.size(), 3}, {points.size() + 1, 3}, {points.size() + 2, 9}});
  VerifyOptions options;
  options.against_cgal = true;
  const auto result = verify(folder.path(), options, {});
  ASSERT_TRUE(result) << result.error().where;
  EXPECT_EQ(result.value().vertices, points.size());
  EXPECT_EQ(result.value().cells, manifest.cells);
  // Every facet has two sides but those of the hull.
  EXPECT_EQ(2 * result.value().facets - result.value().hull_facets,
            manifest.cells * static_cast<std::uint64_t>(dimension + 1));
  EXPECT_EQ(result.value().passed.size(), 8u);
}
INSTANTIATE_TEST_SUITE_P(Clouds, SoundResult,
                         testing::Combine(testing::Values(2, 3),
                                          testing::Values(Shape::uniform, Shape::lattice, Shape::sphere,
                                                          Shape::terrain),
                                          testing::Values(1u, 5u, 60u), testing::Bool()));

TEST(Verify, WithLittleMemoryTheAnswerIsTheSame) {
  const auto meshes = sample_tiles(sample_points(Shape::uniform, 3, 6000), 3, 60);
  const TemporaryFolder folder, scratch;
  store_sample(folder.path(), meshes);
  VerifyOptions options;
  options.scratch = scratch.path();
  const auto plenty = verify(folder.path(), options, {});
  options.memory_bytes = 1;
  const auto little = verify(folder.path(), options, {});
  ASSERT_TRUE(plenty) << plenty.error().where;
  ASSERT_TRUE(little) << little.error().where;
  EXPECT_EQ(plenty.value().facets, little.value().facets);
  EXPECT_EQ(plenty.value().hull_facets, little.value().hull_facets);
  EXPECT_TRUE(fs::is_empty(scratch.path()));
}

TEST(Verify, HugeAndTinyCoordinatesPass) {
  for (const double scale : {1e-300, 1e-160, 1e100, 1e150}) {
    auto points = sample_points(Shape::uniform, 2, 60);
    for (auto& p : points) p = {p.x * scale, p.y * scale, 0};
    const auto result = verify_meshes(sample_tiles(points, 2, 3));
    EXPECT_TRUE(result) << scale << ": " << result.error().where;
  }
}

TEST(Verify, StopsWhenAsked) {
  const TemporaryFolder folder;
  store_sample(folder.path(), sample_tiles(sample_points(Shape::uniform, 3, 100), 3, 2));
  std::stop_source stop;
  stop.request_stop();
  const auto result = verify(folder.path(), {}, stop.get_token());
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, Errc::interrupted);
}

class DamagedResult : public testing::TestWithParam<std::tuple<int, bool>> {
 protected:
  int dimension() const { return std::get<0>(GetParam()); }
  bool neighbors() const { return std::get<1>(GetParam()); }
  Meshes meshes_ = sample_tiles(sample_points(Shape::uniform, dimension(), 300), dimension(), 3);
};
INSTANTIATE_TEST_SUITE_P(All, DamagedResult, testing::Combine(testing::Values(2, 3), testing::Bool()));

TEST_P(DamagedResult, AHoleIsFound) {
  const auto cell =
      find_cell(meshes_[0], [&](std::size_t c) { return all_own(meshes_[0], c) && !on_hull(meshes_[0], c); });
  remove_cell(meshes_, ids_of(meshes_[0], cell));
  expect_wrong(meshes_, "hull", neighbors());
}

TEST_P(DamagedResult, ADentInTheHullIsFound) {
  const auto cell = find_cell(meshes_[0], [&](std::size_t c) { return on_hull(meshes_[0], c); });
  remove_cell(meshes_, ids_of(meshes_[0], cell));
  expect_wrong(meshes_, "hull", neighbors());
}

TEST_P(DamagedResult, AMissingCopyOfACellIsFound) {
  const auto cell = find_cell(meshes_[1], [&](std::size_t c) { return meshes_[1].cell_ghost[c] == 1; });
  remove_cell(meshes_, ids_of(meshes_[1], cell), 1);
  const auto result = verify_meshes(meshes_, neighbors());
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, Errc::not_delaunay);
}

TEST_P(DamagedResult, AVertexMovedEverywhereIsFound) {
  // To another vertex of its tile, slightly displaced: cells around it turn over.
  const std::uint64_t id = meshes_[0].ids[0];
  const Point to = meshes_[0].points[9];
  for (auto& mesh : meshes_)
    for (std::size_t i = 0; i < mesh.ids.size(); ++i)
      if (mesh.ids[i] == id) mesh.points[i] = {to.x + 1e-4, to.y + 1e-4, to.z};
  expect_wrong(meshes_, "cell ", neighbors());
}

TEST_P(DamagedResult, AVertexMovedInOneTileAloneIsFound) {
  for (auto& mesh : meshes_)
    for (std::size_t i = 0; i < mesh.ids.size(); ++i)
      if (mesh.point_ghost[i] == 1) {
        mesh.points[i].x = std::nextafter(mesh.points[i].x, 2);
        expect_wrong(meshes_, "at other places", neighbors());
        return;
      }
}

TEST_P(DamagedResult, ADuplicatedCellIsFound) {
  TileMesh& mesh = meshes_[0];
  const auto cell = find_cell(mesh, [&](std::size_t c) { return all_own(mesh, c); });
  for (std::size_t k = 0; k < corners(mesh); ++k) {
    mesh.cells.push_back(mesh.cells[cell * corners(mesh) + k]);
    mesh.neighbors.push_back(mesh.neighbors[cell * corners(mesh) + k]);
  }
  mesh.cell_ghost.push_back(0);
  expect_wrong(meshes_, neighbors() ? "does not name it in turn" : "share the facet", neighbors());
}

TEST_P(DamagedResult, ADuplicatedCellOfTwoTilesIsFound) {
  TileMesh& mesh = meshes_[0];
  const auto cell = find_cell(mesh, [&](std::size_t c) { return !all_own(mesh, c); });
  for (std::size_t k = 0; k < corners(mesh); ++k) {
    mesh.cells.push_back(mesh.cells[cell * corners(mesh) + k]);
    mesh.neighbors.push_back(-1);
  }
  mesh.cell_ghost.push_back(1);
  const auto result = verify_meshes(meshes_, neighbors());
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, Errc::not_delaunay);
}

TEST_P(DamagedResult, ACellTurnedOverIsFoundAndNamed) {
  TileMesh& mesh = meshes_[0];
  std::swap(mesh.cells[5 * corners(mesh)], mesh.cells[5 * corners(mesh) + 1]);
  std::swap(mesh.neighbors[5 * corners(mesh)], mesh.neighbors[5 * corners(mesh) + 1]);
  expect_wrong(meshes_, "000000.vtkhdf: cell 5 (vertices ", neighbors());
  expect_wrong(meshes_, "is not positively oriented", neighbors());
}

TEST_P(DamagedResult, AChangedIdIsFound) {
  meshes_[0].ids[3] = meshes_[0].ids[4];
  expect_wrong(meshes_, "vertex", neighbors());
}

TEST_P(DamagedResult, TwoVerticesThatChangePlacesAreFound) {
  std::swap(meshes_[0].ids[3], meshes_[0].ids[4]);  // consistent inside the tile, not with the others
  const std::uint64_t a = meshes_[0].ids[3], b = meshes_[0].ids[4];
  bool seen = false;
  for (std::size_t tile = 1; tile < meshes_.size(); ++tile)
    for (const auto id : meshes_[tile].ids) seen = seen || id == a || id == b;
  const auto result = verify_meshes(meshes_, neighbors());
  EXPECT_EQ(!result, seen) << "ids of vertices that no other tile knows are only names";
  const auto foreign = static_cast<std::size_t>(
      std::find(meshes_[0].point_ghost.begin(), meshes_[0].point_ghost.end(), 1) - meshes_[0].point_ghost.begin());
  std::swap(meshes_[0].ids[foreign], meshes_[0].ids[foreign + 1]);
  expect_wrong(meshes_, "cell ", neighbors());
}

TEST_P(DamagedResult, ACellThatIsMainTwiceIsFound) {
  TileMesh& mesh = meshes_[1];
  mesh.cell_ghost[find_cell(mesh, [&](std::size_t c) { return mesh.cell_ghost[c] == 1; })] = 0;
  expect_wrong(meshes_, "is main here, but tile 0 holds it too", neighbors());
}

TEST_P(DamagedResult, ACellThatIsMainNowhereIsFound) {
  TileMesh& mesh = meshes_[0];
  mesh.cell_ghost[find_cell(mesh, [&](std::size_t c) { return !all_own(mesh, c); })] = 1;
  expect_wrong(meshes_, "is main in no tile", neighbors());
}

TEST_P(DamagedResult, AnInnerCellThatIsNotMainIsFound) {
  TileMesh& mesh = meshes_[0];
  mesh.cell_ghost[find_cell(mesh, [&](std::size_t c) { return all_own(mesh, c); })] = 1;
  expect_wrong(meshes_, "is not main", neighbors());
}

TEST_P(DamagedResult, AVertexWithoutCellsIsFound) {
  TileMesh& mesh = meshes_[0];
  mesh.points.push_back({0.5, 0.5, 0});
  mesh.ids.push_back(300);
  mesh.owners.push_back(0);
  mesh.point_ghost.push_back(0);
  expect_wrong(meshes_, "vertex 300 belongs to no cell", neighbors());
}

TEST_P(DamagedResult, TheSameTriangulationTwiceIsFound) {
  // Every cell, facet and ridge is in order, but space is covered twice.
  Meshes twice = meshes_;
  for (auto mesh : meshes_) {
    for (auto& id : mesh.ids) id += 300;
    twice.push_back(mesh);
  }
  expect_wrong(twice, "winds 2 times", neighbors());
}

TEST_P(DamagedResult, AnEmptyResultIsNoTriangulation) {
  const TemporaryFolder folder;
  Manifest manifest;
  manifest.dimension = dimension();
  ASSERT_TRUE(finish_store(folder.path(), manifest, {}));
  const auto result = verify(folder.path(), {}, {});
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, Errc::not_delaunay);
}

class DamagedNeighbours : public testing::TestWithParam<int> {
 protected:
  Meshes meshes_ = sample_tiles(sample_points(Shape::uniform, GetParam(), 300), GetParam(), 3);
};
INSTANTIATE_TEST_SUITE_P(All, DamagedNeighbours, testing::Values(2, 3));

TEST_P(DamagedNeighbours, EveryWrongEntryIsFound) {
  int tried = 0;
  for (std::size_t tile = 0; tile < meshes_.size(); ++tile)
    for (const std::int32_t from : {-1, -2, 0, 1}) {
      // One entry of each kind, and every other value that might pass for it.
      auto& all = meshes_[tile].neighbors;
      const auto entry =
          std::find_if(all.begin(), all.end(), [&](std::int32_t n) { return from > 0 ? n > 0 : n == from; });
      if (entry == all.end()) continue;
      const std::int32_t right = *entry;
      for (const std::int32_t wrong : {-1, -2, 0, 7}) {
        if (wrong == right) continue;
        *entry = wrong;
        const auto result = verify_meshes(meshes_);
        EXPECT_FALSE(result) << "tile " << tile << ", " << right << " -> " << wrong;
        if (!result) {
          EXPECT_EQ(result.error().code, Errc::not_delaunay) << result.error().where;
        }
        ++tried;
      }
      *entry = right;
    }
  EXPECT_GT(tried, 20);
  EXPECT_TRUE(verify_meshes(meshes_));
}

// Cells without neighbours, as one tile.
TileMesh mesh_of(int dimension, const std::vector<Point>& points, const std::vector<std::vector<int>>& cells) {
  TileMesh mesh;
  mesh.dimension = dimension;
  mesh.points = points;
  for (std::size_t i = 0; i < points.size(); ++i) mesh.ids.push_back(i);
  mesh.owners.assign(points.size(), 0);
  mesh.point_ghost.assign(points.size(), 0);
  for (const auto& cell : cells) {
    mesh.cells.insert(mesh.cells.end(), cell.begin(), cell.end());
    mesh.cell_ghost.push_back(0);
  }
  return mesh;
}

TEST(Verify, AFlippedEdgeIsNotDelaunay) {
  const std::vector<Point> kite{{0, 0, 0}, {4, 0, 0}, {5, 5, 0}, {0, 4, 0}};
  EXPECT_TRUE(verify_meshes({mesh_of(2, kite, {{0, 1, 3}, {1, 2, 3}})}, false));
  expect_wrong({mesh_of(2, kite, {{0, 1, 2}, {0, 2, 3}})}, "is not Delaunay: vertex 3 of cell 1 (vertices 0 2 3)",
               false);
}

TEST(Verify, AFlippedPairOfTetrahedraIsNotDelaunay) {
  // Two flat tetrahedra on one base, or three around the axis of their tops: the axis is short, so three are right.
  const std::vector<Point> points{{0, 0, 0}, {9, 0, 0}, {0, 9, 0}, {3, 3, 1}, {3, 3, -1}};
  EXPECT_TRUE(verify_meshes({mesh_of(3, points, {{0, 1, 4, 3}, {1, 2, 4, 3}, {2, 0, 4, 3}})}, false));
  expect_wrong({mesh_of(3, points, {{0, 1, 2, 3}, {1, 0, 2, 4}})}, "is not Delaunay", false);
}

TEST(Verify, ATieBrokenTheWrongWayIsFoundOnASquare) {
  const std::vector<Point> square{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  const bool a = verify_meshes({mesh_of(2, square, {{0, 1, 3}, {1, 2, 3}})}, false).has_value();
  const bool b = verify_meshes({mesh_of(2, square, {{0, 1, 2}, {0, 2, 3}})}, false).has_value();
  EXPECT_NE(a, b) << "one of the diagonals is right";
}

TEST(Verify, ATieBrokenTheWrongWayIsFoundOnACube) {
  // Mirrored, the cube's points have another order, and so another tie rule: each of its triangulations is Delaunay.
  std::vector<Point> cube, mirrored;
  for (int i = 0; i < 8; ++i) {
    cube.push_back({static_cast<double>(i & 1), static_cast<double>(i >> 1 & 1), static_cast<double>(i >> 2)});
    mirrored.push_back({1 - cube.back().x, cube.back().y, cube.back().z});
  }
  const auto right = sample_tiles(cube, 3, 1);
  EXPECT_TRUE(verify_meshes(right));
  auto wrong = sample_tiles(mirrored, 3, 1);
  wrong[0].points.clear();
  for (const auto id : wrong[0].ids) wrong[0].points.push_back(cube[id]);
  for (std::size_t c = 0; c < wrong[0].cell_ghost.size(); ++c) {
    std::swap(wrong[0].cells[4 * c], wrong[0].cells[4 * c + 1]);
    std::swap(wrong[0].neighbors[4 * c], wrong[0].neighbors[4 * c + 1]);
  }
  std::set<std::set<std::uint64_t>> a, b;
  for (std::size_t c = 0; c < right[0].cell_ghost.size(); ++c) a.insert(ids_of(right[0], c));
  for (std::size_t c = 0; c < wrong[0].cell_ghost.size(); ++c) b.insert(ids_of(wrong[0], c));
  ASSERT_NE(a, b);
  expect_wrong(wrong, "is not Delaunay");
  expect_wrong(wrong, "is not Delaunay", false);
}

TEST(Verify, AFlippedByteIsACorruptFileWhereverItIs) {
  const TemporaryFolder folder;
  store_sample(folder.path(), sample_tiles(sample_points(Shape::uniform, 3, 100), 3, 2), {}, {{100, 5}});
  for (const auto& path : {tile_file(folder.path(), TileId{1}), folder.path() / "triangulation.vtkhdf",
                           folder.path() / "duplicates.bin"}) {
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
  const std::vector<std::pair<std::uint64_t, std::uint64_t>> duplicates{{100, 5}, {101, 6}};
  Manifest manifest = store_sample(folder.path(), meshes, {}, duplicates);
  const auto verify_with = [&](const std::function<void(Manifest&)>& change, const auto& pairs) {
    Manifest changed = manifest;
    change(changed);
    EXPECT_TRUE(finish_store(folder.path(), changed, pairs));
    return verify(folder.path(), {}, {});
  };
  EXPECT_TRUE(verify_with([](Manifest&) {}, duplicates));
  EXPECT_TRUE(verify_with([](Manifest& m) { m.points_read += m.filtered = 3; }, duplicates));
  using Pairs = std::vector<std::pair<std::uint64_t, std::uint64_t>>;
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

}  // namespace
}  // namespace tessera
