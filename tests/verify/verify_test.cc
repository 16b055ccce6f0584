// Sound results pass, and small triangulations that are known to be right or wrong are told apart.
#include "src/result/verify/verify.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "src/result/verify/against_cgal.h"
#include "src/result/verify/match_facets.h"
#include "tests/verify/verify_testing.h"

namespace tessera::test {
namespace {

namespace fs = std::filesystem;

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
  // What users read of it.
  const std::vector<std::string> passed{
      "checksums of all files; the master file leads to these tiles, and there are no others",
      "vertices = points - duplicates - rejects; every vertex is one tile's own, with the same coordinates everywhere",
      "every cell is main in exactly one tile, and present where its vertices are",
      "every cell is positively oriented",
      neighbors ? "every facet is shared by two cells that name each other, or is on the hull"
                : "every facet is shared by two cells, or is on the hull",
      "every facet inside is locally Delaunay, exactly, with the perturbation's tie rule",
      "the hull is closed, convex and encloses its interior exactly once",
      "the tiles' boxes cover space without overlap, and each vertex is of the tile that the partition gives it to; "
      "the "
      "bounds are the vertices'",
      "the digest " + digest_text(manifest.digest.value()),
      "the set of cells equals that of CGAL's triangulation of all vertices"};
  EXPECT_EQ(result.value().passed, passed);
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

TEST(Verify, StopsWhileItComparesWithCgalAndWhileItLooksForNeighbours) {
  for (const int dimension : {2, 3}) {
    auto meshes = sample_tiles(sample_points(Shape::uniform, dimension, 6000), dimension, 1);
    std::stop_source stop;
    AgainstCgal cgal(dimension, {}, stop.get_token());
    cgal.add(meshes.front());
    EXPECT_TRUE(cgal.compare("out"));
    stop.request_stop();
    const auto stopped = cgal.compare("out");
    ASSERT_FALSE(stopped);
    EXPECT_EQ(stopped.error().code, Errc::interrupted);
    EXPECT_EQ(match_facets(meshes.front(), "out/tiles/000000.vtu", stop.get_token()).error().code, Errc::interrupted);
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

// Cells without neighbours, as one tile.
TileMesh mesh_of(int dimension, const std::vector<Point>& points, const std::vector<std::vector<int>>& cells) {
  TileMesh mesh;
  mesh.dimension = dimension;
  mesh.points = points;
  for (std::size_t i = 0; i < points.size(); ++i) mesh.ids.push_back({i});
  mesh.owners.assign(points.size(), TileId{0});
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
  for (const auto id : wrong[0].ids) wrong[0].points.push_back(cube[id.value]);
  for (std::size_t c = 0; c < wrong[0].cell_ghost.size(); ++c) {
    std::swap(wrong[0].cells[4 * c], wrong[0].cells[4 * c + 1]);
    std::swap(wrong[0].neighbors[4 * c], wrong[0].neighbors[4 * c + 1]);
  }
  std::set<std::set<PointId>> a, b;
  for (std::size_t c = 0; c < right[0].cell_ghost.size(); ++c) a.insert(ids_of(right[0], c));
  for (std::size_t c = 0; c < wrong[0].cell_ghost.size(); ++c) b.insert(ids_of(wrong[0], c));
  ASSERT_NE(a, b);
  expect_wrong(wrong, "is not Delaunay");
  expect_wrong(wrong, "is not Delaunay", false);
}

TEST(Verify, AResultOfAnOldFormatIsStillProven) {
  VerifyOptions options;
  options.against_cgal = true;
  const auto report = verify(fs::path(TESSERA_TEST_DATA) / "format-2", options, {});
  ASSERT_TRUE(report) << report.error().where;
  EXPECT_EQ(report.value().cells, 263u);
}

}  // namespace
}  // namespace tessera::test
