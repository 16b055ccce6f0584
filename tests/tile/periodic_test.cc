#include "tests/tile/periodic.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>
#include <string>

#include "src/base/image.h"
#include "src/result/store/digest.h"
#include "tests/tile/splay.h"

namespace tessera::testing {
namespace {

std::string text_of(const PeriodicCloud& cloud, const PeriodicOptions& o) {
  std::string text = "seed " + std::to_string(o.seed) + ", " + std::to_string(cloud.dimension) + "D, " +
                     std::to_string(cloud.points.size()) + " points, " + std::to_string(o.tiles) + " tiles " + o.how +
                     ", periods";
  for (const double length : cloud.period.length) text += " " + std::to_string(length);
  return text;
}

// Whole numbers, so that copies are exact: a few random points or a lattice, and periods that are alike or very
// different, along some or all axes.
PeriodicCloud random_cloud(std::mt19937_64& rng) {
  PeriodicCloud cloud;
  cloud.dimension = 2 + static_cast<int>(rng() % 2);
  const auto d = static_cast<std::uint64_t>(cloud.dimension);
  const std::uint64_t all = (std::uint64_t{1} << d) - 1, periodic = rng() % 2 == 0 ? all : 1 + rng() % all;
  std::array<std::uint64_t, 3> size{1, 1, 1};
  const std::uint64_t side = 1 + rng() % 6;
  for (std::size_t axis = 0; axis < d; ++axis) {
    size[axis] = rng() % 3 == 0 ? 1 + rng() % 8 : rng() % 8 == 0 ? 1 + rng() % 1000 : side;
    if (rng() % 8 == 0) size[axis] *= 1'000;
    if ((periodic >> axis & 1) != 0) cloud.period.length[axis] = static_cast<double>(size[axis]);
  }
  std::set<std::array<std::uint64_t, 3>> places;
  const std::uint64_t points = 1 + rng() % (rng() % 4 == 0 ? 60 : 12), step = rng() % 3 == 0 ? 1 + rng() % 3 : 0;
  for (std::uint64_t i = 0; i < points; ++i) {
    if (step == 0) {
      places.insert({rng() % size[0], rng() % size[1], rng() % size[2]});
    } else {
      places.insert({i % size[0], i / 3 * step % size[1], i / 9 % size[2]});
    }
  }
  for (const auto& p : places) {
    cloud.points.push_back({{static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])},
                            PointId{cloud.points.size()}});
  }
  std::shuffle(cloud.points.begin(), cloud.points.end(), rng);
  return cloud;
}

PeriodicCloud lattice(int dimension, int side, double length) {
  PeriodicCloud cloud;
  cloud.dimension = dimension;
  for (int axis = 0; axis < dimension; ++axis) cloud.period.length[static_cast<std::size_t>(axis)] = length;
  for (int i = 0; i < (dimension == 3 ? side * side * side : side * side); ++i) {
    const double x = i % side, y = i / side % side, z = i / side / side;
    cloud.points.push_back(
        {{x * length / side, y * length / side, z * length / side}, PointId{static_cast<std::uint64_t>(i)}});
  }
  return cloud;
}

// 2 times the area, or 6 times the volume, of all main cells. REQUIRES: coordinates are small whole numbers.
std::int64_t measure_of(const std::vector<TileMesh>& meshes) {
  std::int64_t sum = 0;
  for (const TileMesh& m : meshes) {
    const auto corners = static_cast<std::size_t>(m.dimension) + 1;
    for (std::size_t c = 0; c < m.cell_ghost.size(); ++c) {
      if (m.cell_ghost[c] != 0) continue;
      std::int64_t e[3][3] = {{0, 0, 0}, {0, 0, 0}, {0, 0, 1}};
      const auto at = [&](std::size_t i) { return m.points[static_cast<std::size_t>(m.cells[c * corners + i])]; };
      for (std::size_t i = 1; i < corners; ++i) {
        for (int k = 0; k < m.dimension; ++k) e[i - 1][k] = static_cast<std::int64_t>(at(i)[k] - at(0)[k]);
      }
      sum += e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) - e[0][1] * (e[1][0] * e[2][2] - e[1][2] * e[2][0]) +
             e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]);
    }
  }
  return sum;
}

std::int64_t measure_of_box(const PeriodicCloud& cloud) {
  const auto length = [&](std::size_t axis) { return static_cast<std::int64_t>(cloud.period.length[axis]); };
  return cloud.dimension == 2 ? 2 * length(0) * length(1) : 6 * length(0) * length(1) * length(2);
}

std::vector<PeriodicCell> cells_of_tiles(const PeriodicCloud& cloud, const PeriodicOptions& options) {
  const std::vector<TileMesh> meshes = periodic_splay(cloud, options);
  for (const TileMesh& mesh : meshes) EXPECT_EQ(inconsistency(mesh, mesh.owners[0]), "");
  return periodic_main_cells(meshes);
}

TEST(Image, OffsetsComeBackAndNoneIsZero) {
  EXPECT_EQ(image::code({}), 0u);
  for (std::uint32_t code = 0; code < image::codes; ++code) {
    const PeriodOffset o = image::offset(code);
    EXPECT_EQ(image::code(o), code);
    EXPECT_EQ(offset_of(image_of(PointId{12345678901}, o)), o);
    EXPECT_EQ(plain(image_of(PointId{12345678901}, o)), PointId{12345678901});
    EXPECT_EQ(offset_of(image_of(TileId{999'999}, o)), o);
    EXPECT_EQ(plain(image_of(TileId{999'999}, o)), TileId{999'999});
    for (std::uint32_t other = 0; other < image::codes; ++other) {
      const PeriodOffset p = image::offset(other);
      EXPECT_EQ(rank_of(image_of(TileId{7}, o)) < rank_of(image_of(TileId{7}, p)), o < p);
      EXPECT_LT(rank_of(image_of(TileId{6}, o)), rank_of(image_of(TileId{7}, p)));
    }
  }
}

// The proof says that three copies are enough for brute force, whatever the number of points.
TEST(PeriodicReference, ThreeCopiesAlongEachAxisAreEnough) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    std::mt19937_64 rng(seed);
    const PeriodicCloud cloud = random_cloud(rng);
    if (cloud.points.size() > 16) continue;
    EXPECT_EQ(periodic_delaunay(cloud, 3), periodic_delaunay(cloud, 5)) << "seed " << seed;
  }
}

// In a torus Euler's characteristic is 0: twice as many triangles as vertices.
TEST(PeriodicReference, ATorusHasTwiceAsManyTrianglesAsVertices) {
  for (const int side : {1, 2, 3, 5}) {
    EXPECT_EQ(periodic_delaunay(lattice(2, side, 8 * side), 3).size(), static_cast<std::size_t>(2 * side * side));
  }
}

class PeriodicTiles : public ::testing::TestWithParam<std::uint64_t> {};

TEST_P(PeriodicTiles, MainCellsAreThoseOfManyCopiesWhateverTilesSeedsAndOrder) {
  for (std::uint64_t seed = GetParam() * 250; seed < (GetParam() + 1) * 250; ++seed) {
    std::mt19937_64 rng(seed);
    const PeriodicCloud cloud = random_cloud(rng);
    const auto expected = periodic_delaunay(cloud, 3);
    if (expected.empty()) continue;  // flat
    PeriodicOptions options;
    options.seed = seed;
    options.tiles = 1 + static_cast<std::uint32_t>(rng() % 6);
    options.how = rng() % 3 == 0 ? "single" : rng() % 2 == 0 ? "stripes" : "random";
    if (options.how == "single" && cloud.points.size() > 16) options.how = "stripes";
    options.kernel = rng() % 4 == 0 ? KernelKind::cgal : KernelKind::flat;
    options.announce = rng() % 3 != 0;
    options.reduce = rng() % 2 == 0;
    options.counted = rng() % 3 == 0;
    options.sleep = rng() % 3 == 0;
    options.reborn = rng() % 4 == 0;
    options.random_seeds = rng() % 2 == 0;
    ASSERT_EQ(cells_of_tiles(cloud, options), expected) << text_of(cloud, options);
  }
}
INSTANTIATE_TEST_SUITE_P(Seeds, PeriodicTiles, ::testing::Range(std::uint64_t{0}, std::uint64_t{8}));

// Without brute force: this many points have no copies here.
TEST(PeriodicLattice, MainCellsAddUpToTheBoxExactly) {
  for (const auto& [dimension, side] : {std::pair(2, 1), std::pair(2, 40), std::pair(3, 1), std::pair(3, 10)}) {
    const PeriodicCloud cloud = lattice(dimension, side, 4.0 * side);
    for (const std::uint32_t tiles : {1, 4}) {
      PeriodicOptions options;
      options.tiles = tiles;
      options.how = "stripes";
      options.reduce = true;
      EXPECT_EQ(measure_of(periodic_splay(cloud, options)), measure_of_box(cloud)) << text_of(cloud, options);
    }
  }
}

TEST(PeriodicLattice, IsRightFromOnePointOnForOneTileAndMany) {
  for (const auto& [dimension, most] : {std::pair(2, 6), std::pair(3, 4)}) {
    for (int side = 1; side <= most; ++side) {
      const PeriodicCloud cloud = lattice(dimension, side, 8.0 * side);
      const auto expected = periodic_delaunay(cloud, 3);
      for (const std::uint32_t tiles : {1, 2, 7}) {
        PeriodicOptions options;
        options.tiles = tiles;
        options.how = tiles == 1 ? "random" : "stripes";
        options.reduce = true;
        ASSERT_EQ(cells_of_tiles(cloud, options), expected) << text_of(cloud, options);
      }
    }
  }
}

Digest digest_of_tiles(const PeriodicCloud& cloud, std::uint32_t tiles) {
  PeriodicOptions options;
  options.tiles = tiles;
  options.how = "stripes";
  Digest sum;
  for (const TileMesh& mesh : periodic_splay(cloud, options)) sum += digest_of(mesh);
  return sum;
}

// The copy of a cell that is main follows the tiles. The digest does not.
TEST(PeriodicDigest, IsTheSameForAnyTilesAndKnowsOffsets) {
  PeriodicCloud cloud = lattice(3, 3, 24);
  const Digest one = digest_of_tiles(cloud, 1);
  EXPECT_EQ(digest_of_tiles(cloud, 2), one);
  EXPECT_EQ(digest_of_tiles(cloud, 7), one);
  // A cell that is the same set of points, but not of images.
  PeriodicOptions options;
  TileMesh mesh = periodic_splay(cloud, options).front();
  ASSERT_EQ(digest_of(mesh), one);
  const auto shifted = std::find_if(mesh.offsets.begin(), mesh.offsets.end(), [](auto code) { return code != 0; });
  ASSERT_NE(shifted, mesh.offsets.end());
  *shifted = static_cast<std::uint8_t>(*shifted % 26 + 1);
  EXPECT_NE(digest_of(mesh), one);
}

// Enough points that most cells are final, and that no tile knows all.
TEST(PeriodicLarge, FinalCellsAndTheRestAreTheCellsOfManyCopies) {
  for (const int dimension : {2, 3}) {
    std::mt19937_64 rng(5);
    PeriodicCloud cloud;
    cloud.dimension = dimension;
    for (int axis = 0; axis < dimension; ++axis) cloud.period.length[static_cast<std::size_t>(axis)] = 1'024;
    std::set<std::array<std::uint64_t, 3>> places;
    while (places.size() < 2'000) places.insert({rng() % 1'024, rng() % 1'024, dimension == 3 ? rng() % 1'024 : 0});
    for (const auto& p : places) {
      cloud.points.push_back({{static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])},
                              PointId{cloud.points.size()}});
    }
    const auto expected = periodic_delaunay(cloud, 3);
    for (const std::uint32_t tiles : {1, 5}) {
      PeriodicOptions options;
      options.tiles = tiles;
      options.how = "stripes";
      options.reduce = true;
      ASSERT_EQ(cells_of_tiles(cloud, options), expected) << text_of(cloud, options);
      options.counted = true;
      ASSERT_EQ(cells_of_tiles(cloud, options), expected) << text_of(cloud, options);
    }
  }
}

}  // namespace
}  // namespace tessera::testing
