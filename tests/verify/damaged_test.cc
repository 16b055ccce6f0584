// Meshes that are no triangulation, in files that are in order.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>

#include "tests/verify/verify_testing.h"

namespace tessera::test {
namespace {

// Takes a cell away from every tile, or from the given one alone; its neighbours then have the outside there.
void remove_cell(Meshes& meshes, const std::set<PointId>& ids, int only_tile = -1) {
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
  const PointId id = meshes_[0].ids[0];
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
  expect_wrong(meshes_, "000000.vtu: cell 5 (vertices ", neighbors());
  expect_wrong(meshes_, "is not positively oriented", neighbors());
}

TEST_P(DamagedResult, AChangedIdIsFound) {
  meshes_[0].ids[3] = meshes_[0].ids[4];
  expect_wrong(meshes_, "vertex", neighbors());
}

TEST_P(DamagedResult, TwoVerticesThatChangePlacesAreFound) {
  std::swap(meshes_[0].ids[3], meshes_[0].ids[4]);  // consistent inside the tile, not with the others
  const PointId a = meshes_[0].ids[3], b = meshes_[0].ids[4];
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
  mesh.ids.push_back({300});
  mesh.owners.push_back({0});
  mesh.point_ghost.push_back(0);
  expect_wrong(meshes_, "vertex 300 belongs to no cell", neighbors());
}

TEST_P(DamagedResult, TheSameTriangulationTwiceIsFound) {
  // Every cell, facet and ridge is in order, but space is covered twice.
  Meshes twice = meshes_;
  for (auto mesh : meshes_) {
    for (auto& id : mesh.ids) id.value += 300;
    for (auto& owner : mesh.owners) owner.value += static_cast<std::uint32_t>(meshes_.size());
    twice.push_back(mesh);
  }
  expect_wrong(twice, "winds 2 times", neighbors());
}

TEST_P(DamagedResult, AnEmptyResultIsNoTriangulation) {
  const TemporaryFolder folder;
  Manifest manifest;
  manifest.dimension = dimension();
  manifest.boxes.resize(1);
  manifest.partition =
      R"({"kind": "kdtree", "dimension": )" + std::to_string(dimension()) + R"(, "tiles": 1, "splits": []})";
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

}  // namespace
}  // namespace tessera::test
