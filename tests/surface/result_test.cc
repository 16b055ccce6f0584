// Surfaces of results: the same whatever the tiles, closed, and what the options say.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>
#include <string>
#include <vector>

#include "src/job/engine_steps.h"
#include "src/surface/region.h"
#include "src/surface/surface.h"
#include "src/surface/surface_tile.h"
#include "tests/store/sample_result.h"
#include "tests/surface/triangles_of_result.h"

namespace tessera::surface {
namespace {

namespace fs = std::filesystem;
using Bottom = SurfaceOptions::Bottom;
using test::Shape;

constexpr std::uint64_t enough = std::uint64_t{1} << 30;

// Tile i of the points, which are any.
void store(const fs::path& out, const std::vector<Point>& points, std::uint32_t tiles, std::uint64_t partition,
           bool as_points = false) {
  const auto meshes =
      partition == 0 ? test::sample_tiles(points, 3, tiles) : test::sample_tiles(points, 3, tiles, [&](std::size_t i) {
        return static_cast<std::uint32_t>((i * 2654435761u ^ partition) / 7 % tiles);
      });
  test::store_sample(out, meshes, {}, {}, {}, [&](TileId) { return as_points ? TileKind::points : TileKind::cells; });
}

class SurfaceOfShape : public testing::TestWithParam<Shape> {};

TEST_P(SurfaceOfShape, IsClosedAndTheSameWhateverTilesThreadsAndMemory) {
  const auto points = test::sample_points(GetParam(), 3, 700);
  for (const auto& [bottom_inside, unknown_inside] :
       {std::pair(true, true), std::pair(false, true), std::pair(true, false), std::pair(false, false)}) {
    SurfaceOptions options;
    options.bottom = bottom_inside ? Bottom::closed : Bottom::free;
    options.unknown_inside = unknown_inside;
    options.memory_bytes = enough;
    const test::TemporaryFolder one;
    store(one.path() / "out", points, 1, 0);
    const Triangles wanted = triangles_of(one.path() / "out", options);
    EXPECT_EQ(open_edge(wanted.main), std::vector<PointId>());
    if (bottom_inside) {
      EXPECT_GT(wanted.main.size(), points.size() / 4);
    }
    for (const auto& [tiles, partition] :
         {std::pair(2u, 0), std::pair(7u, 0), std::pair(2u, 1), std::pair(5u, 77), std::pair(40u, 5)}) {
      const test::TemporaryFolder some;
      store(some.path() / "out", points, tiles, static_cast<std::uint64_t>(partition), tiles == 7);
      for (const auto& [memory, threads] :
           {std::pair(enough, 2u), std::pair(enough, 3u), std::pair(std::uint64_t{0}, 1u)}) {
        SurfaceOptions other = options;
        other.memory_bytes = memory;
        other.threads = threads;
        const Triangles found = triangles_of(some.path() / "out", other);
        ASSERT_EQ(found.main, wanted.main) << tiles << " tiles, partition " << partition;
        // Each is main in one tile, and ghosts are triangles that are main elsewhere.
        EXPECT_EQ(found.in_tiles.size(), found.main.size());
        if (partition != 0) {
          EXPECT_GT(found.handed_over, 0u);
        }
      }
    }
  }
}
TEST_P(SurfaceOfShape, CanBeMadeManifoldWhateverTheTiles) {
  const auto points = test::sample_points(GetParam(), 3, 1500);
  std::uint64_t added = 0;
  for (const double trim : {1e30, 0.2}) {
    SurfaceOptions options;
    options.trim = trim;
    options.memory_bytes = enough;
    options.energy.lambda = 0.01;  // ragged
    const test::TemporaryFolder one;
    store(one.path() / "out", points, 1, 0);
    const Triangles before = triangles_of(one.path() / "out", options);
    options.manifold = true;
    const Triangles wanted = triangles_of(one.path() / "out", options);
    EXPECT_EQ(not_manifold(wanted.main), "") << trim;
    EXPECT_EQ(not_manifold(before.main).empty(), wanted.added == 0);
    if (trim > 1) {
      EXPECT_EQ(open_edge(wanted.main), std::vector<PointId>());
    }
    EXPECT_EQ(wanted.points.size(), before.points.size() + wanted.added);
    added += wanted.added;
    for (const auto& [tiles, partition] : {std::pair(2u, 0), std::pair(5u, 77), std::pair(40u, 5)}) {
      const test::TemporaryFolder some;
      store(some.path() / "out", points, tiles, static_cast<std::uint64_t>(partition));
      const Triangles found = triangles_of(some.path() / "out", options);
      ASSERT_EQ(found.main, wanted.main) << tiles << " tiles, partition " << partition;
      EXPECT_EQ(found.points, wanted.points);
      EXPECT_EQ(found.in_tiles.size(), found.main.size());
    }
  }
  EXPECT_GT(added, 0u);
}

std::string name_of(const testing::TestParamInfo<Shape>& shape) {
  constexpr const char* names[] = {"uniform", "lattice", "sphere", "terrain"};
  return names[static_cast<std::size_t>(shape.param)];
}
INSTANTIATE_TEST_SUITE_P(Surfaces, SurfaceOfShape,
                         testing::Values(Shape::uniform, Shape::lattice, Shape::sphere, Shape::terrain), name_of);

TEST(Surface, OfASphereSeenFromAllAroundIsTheSphere) {
  const auto points = test::sample_points(Shape::sphere, 3, 2000);
  const test::TemporaryFolder folder;
  store(folder.path() / "out", points, 4, 3);
  SensorOptions sensors{.kind = SensorOptions::Kind::positions, .positions = {}};
  const double radius = std::hypot(points[0].x, points[0].y, points[0].z);
  for (const double x : {-9.0, 9.0})
    for (const double y : {-8.0, 8.0})
      for (const double z : {-7.0, 7.0}) sensors.positions.push_back({x * radius, y * radius, z * radius});
  SurfaceOptions options;
  options.sensors = sensors;
  options.bottom = Bottom::free;
  options.memory_bytes = enough;
  options.threads = 2;
  const Triangles found = triangles_of(folder.path() / "out", options);
  EXPECT_EQ(open_edge(found.main), std::vector<PointId>());
  // Euler: a closed triangulated sphere has twice its vertices less 4 triangles.
  EXPECT_EQ(found.main.size(), 2 * found.points.size() - 4);
  EXPECT_GT(found.points.size(), points.size() * 9 / 10);
  double volume = 0;
  for (const IdTriangle& t : found.main) {
    const Point &a = found.points.at(t[0]), &b = found.points.at(t[1]), &c = found.points.at(t[2]);
    volume += (a.x * (b.y * c.z - b.z * c.y) + a.y * (b.z * c.x - b.x * c.z) + a.z * (b.x * c.y - b.y * c.x)) / 6;
  }
  EXPECT_NEAR(volume / (4 * std::acos(-1.0) / 3 * radius * radius * radius), 1, 0.02);
}

TEST(Surface, ThatIsOpenBelowEndsOnlyAtTheHull) {
  const auto points = test::sample_points(Shape::terrain, 3, 900);
  const test::TemporaryFolder folder;
  store(folder.path() / "out", points, 3, 0);
  SurfaceOptions options;
  options.memory_bytes = enough;
  const Triangles closed = triangles_of(folder.path() / "out", options);
  options.bottom = Bottom::open;
  const Triangles open = triangles_of(folder.path() / "out", options);
  EXPECT_LT(open.main.size(), closed.main.size());
  EXPECT_NE(open_edge(open.main), std::vector<PointId>());
  options.bottom = Bottom::closed;
  options.trim = 1e-9;
  EXPECT_TRUE(triangles_of(folder.path() / "out", options).main.empty());
}

TEST(Surface, HasGroundBelowButNotBeyondLeaningSides) {
  const std::vector<Point> points{{0, 0, 0}, {10, 0, 0}, {0, 10, 0}, {10, 10, 0.125}, {13, 5, 10}};
  StoredTile stored;
  stored.mesh = test::sample_tiles(points, 3, 1).front();
  const SurfaceTile tile = SurfaceTile::make(TileId{0}, "all", std::move(stored)).value();
  int below = 0, leaning = 0;
  for (std::int32_t cell = 0; cell < tile.cells(); ++cell) {
    for (std::size_t k = 0; k < 4; ++k) {
      if (tile.neighbor(cell, k) != SurfaceTile::outside) continue;
      const auto corners = tile.facet(cell, k);
      const bool has_top = std::any_of(corners.begin(), corners.end(), [](const Corner& c) { return c.at.z > 9; });
      const bool inside = is_inside_beyond(tile, cell, k, {});
      EXPECT_FALSE(is_inside_beyond(tile, cell, k, {.lower_inside = false, .unknown_inside = true}));
      if (!has_top) below += inside ? 1 : 0;
      if (has_top) leaning += inside ? 1 : 0;
    }
  }
  EXPECT_EQ(below, 2);
  EXPECT_EQ(leaning, 0);
}

TEST(Surface, IsRefusedWithASentence) {
  const test::TemporaryFolder folder;
  store(folder.path() / "out", test::sample_points(Shape::uniform, 3, 50), 2, 0);
  const auto flat = test::sample_tiles(test::sample_points(Shape::uniform, 2, 50), 2, 1);
  test::store_sample(folder.path() / "flat", flat);
  Engine engine(1, enough, kinds_of_stages());
  Progress progress;
  EngineSteps steps(engine, {.threads = 1, .memory_bytes = enough}, progress);
  const auto refused = [&](const char* result, const SurfaceOptions& options) {
    const auto made = make_surface(folder.path() / result, folder.path() / "mesh.ply", options, steps, {});
    EXPECT_FALSE(made);
    EXPECT_FALSE(fs::exists(folder.path() / "mesh.ply"));
    EXPECT_FALSE(fs::exists(folder.path() / "mesh.ply.surface"));
    return made ? std::string() : made.error().where;
  };
  EXPECT_NE(refused("flat", {}).find("2D triangulation"), std::string::npos);
  SurfaceOptions options;
  options.energy.lambda = -1;
  EXPECT_NE(refused("out", options).find("lambda"), std::string::npos);
  options = {};
  options.energy.alpha = 0;
  EXPECT_NE(refused("out", options).find("alpha"), std::string::npos);
  options = {};
  options.energy.sigma = std::nan("");
  EXPECT_NE(refused("out", options).find("sigma"), std::string::npos);
  options = {};
  options.sensors.kind = SensorOptions::Kind::fields;
  EXPECT_NE(refused("out", options).find("x_origin"), std::string::npos);
  options = {};
  options.sensors = {.kind = SensorOptions::Kind::positions,
                     .positions = {test::sample_points(Shape::uniform, 3, 50)[7]}};
  EXPECT_NE(refused("out", options).find("point 7 is where its sensor"), std::string::npos);
}

}  // namespace
}  // namespace tessera::surface
