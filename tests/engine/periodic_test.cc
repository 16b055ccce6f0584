// Periodic clouds through the whole engine: the same cells as brute force and as CGAL's periodic triangulations,
// whatever the tiles; results that verify() proves, and damaged ones that it refuses.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Periodic_2_Delaunay_triangulation_2.h>
#include <CGAL/Periodic_2_Delaunay_triangulation_traits_2.h>
#include <CGAL/Periodic_3_Delaunay_triangulation_3.h>
#include <CGAL/Periodic_3_Delaunay_triangulation_traits_3.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <functional>
#include <map>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "src/base/files/temporary.h"
#include "src/base/image.h"
#include "src/base/periodic_box.h"
#include "src/geometry/reference/periodic_reference.h"
#include "src/result/store/period.h"
#include "src/result/tile_source.h"
#include "src/result/verify/verify.h"
#include "tests/engine/engine_run.h"
#include "tests/engine/sets.h"

namespace tessera::testing {
namespace {

namespace fs = std::filesystem;
using K = CGAL::Exact_predicates_inexact_constructions_kernel;

struct Periodic {
  int dimension = 3;
  std::vector<double> lengths;  // by axis; 0: no period
  std::vector<Point> points;    // anywhere

  double length(int axis) const { return lengths[static_cast<std::size_t>(axis)]; }
};

// What the engine makes of the points: in the box, each once, with the rank of the first of equal points.
PeriodicCloud expected_cloud(const Periodic& given) {
  PeriodicCloud cloud;
  cloud.dimension = given.dimension;
  for (int axis = 0; axis < given.dimension; ++axis)
    cloud.period.length[static_cast<std::size_t>(axis)] = given.length(axis) > 0 ? in_steps(given.length(axis)) : 0;
  const PeriodicBox box(cloud.period);
  std::map<Point, PointId> first;
  for (std::size_t i = 0; i < given.points.size(); ++i) {
    Point p = given.points[i];
    for (int axis = 0; axis < given.dimension; ++axis)
      if (cloud.period.along(axis)) p[axis] = box.moved(p[axis], axis).to;
    first.emplace(p, PointId{i});
  }
  for (const auto& [at, id] : first) cloud.points.push_back({at, id});
  std::sort(cloud.points.begin(), cloud.points.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
  return cloud;
}

class Scratch {
 public:
  // Runs the engine. Each run has a folder of its own.
  fs::path run(const Periodic& given, EngineOptions options) {
    const fs::path out = folder_.path() / std::to_string(runs_++), input = folder_.path() / "cloud.npy";
    std::vector<double> coordinates;
    for (const Point& p : given.points)
      for (int axis = 0; axis < given.dimension; ++axis) coordinates.push_back(p[axis]);
    EXPECT_TRUE(write_npy(input, given.dimension, coordinates));
    options.dimension = given.dimension;
    options.periodic = given.lengths;
    const auto made = run_engine(input, out, options);
    EXPECT_TRUE(made) << made.error().where;
    return out;
  }

 private:
  TemporaryFolder folder_ = TemporaryFolder::make().value();
  int runs_ = 0;
};

std::vector<TileMesh> meshes_of(const fs::path& out) {
  std::vector<TileMesh> meshes;
  const auto source = TileSource::open(out, Periods::known).value();
  for (std::size_t i = 0; i < source.tiles(); ++i) {
    auto read = source.read(i, {});
    EXPECT_TRUE(read) << read.error().where;
    if (read) meshes.push_back(std::move(read).value().mesh);
  }
  return meshes;
}

std::vector<PeriodicCell> cells_of(const fs::path& out) {
  const auto meshes = meshes_of(out);
  return periodic_main_cells(meshes);
}

std::string proof_of(const fs::path& out, bool against_cgal = false) {
  VerifyOptions options;
  options.against_cgal = against_cgal;
  const auto report = verify(out, options, {});
  return report ? "" : report.error().where;
}

EngineOptions with_tiles(std::uint32_t tiles, StoreAs store = StoreAs::cells) {
  EngineOptions options;
  options.tiles = tiles;
  options.threads = 2;
  options.store = store;
  return options;
}

Periodic lattice(int dimension, int side, double length) {
  Periodic cloud{dimension, std::vector<double>(static_cast<std::size_t>(dimension), length), {}};
  for (int i = 0; i < (dimension == 3 ? side * side * side : side * side); ++i)
    cloud.points.push_back({i % side * length / side, i / side % side * length / side,
                            dimension == 3 ? i / side / side * length / side : 0});
  return cloud;
}

// Random points of a kind in boxes that are alike or very different, along some or all axes; also outside of the box.
Periodic random_periodic(std::mt19937_64& rng) {
  std::uniform_real_distribution<double> real(0, 1);
  Periodic cloud;
  cloud.dimension = 2 + static_cast<int>(rng() % 2);
  const auto d = static_cast<std::uint64_t>(cloud.dimension);
  const std::uint64_t all = (std::uint64_t{1} << d) - 1, along = rng() % 2 == 0 ? all : 1 + rng() % all;
  std::array<double, 3> size{1, 1, 1};
  for (std::size_t axis = 0; axis < d; ++axis) {
    size[axis] = rng() % 4 == 0 ? 1 + static_cast<double>(rng() % 40) : rng() % 8 == 0 ? 1000 : 1;
    cloud.lengths.push_back((along >> axis & 1) != 0 ? size[axis] : 0);
  }
  const std::uint64_t open = d - static_cast<std::uint64_t>(std::popcount(along));
  const std::uint64_t points = open + 2 + rng() % (rng() % 3 == 0 ? 100 : 14),
                      grid = rng() % 2 == 0 ? 2 + rng() % 4 : 0;
  const double halo = rng() % 3 == 0 ? 0.01 : 1;
  for (std::uint64_t i = 0; i < points; ++i) {
    Point p;
    for (std::size_t axis = 0; axis < d; ++axis) {
      const double x =
          grid > 0 ? static_cast<double>(rng() % (2 * grid)) / static_cast<double>(grid) : real(rng) * halo;
      p[static_cast<int>(axis)] = (x + (rng() % 5 == 0 ? -1 : 0)) * size[axis];
    }
    cloud.points.push_back(p);
  }
  for (std::uint64_t i = 0; i <= open; ++i) {  // spans the open axes
    Point p;
    if (i > 0) {
      int axis = 0;
      for (std::uint64_t left = i; axis < cloud.dimension; ++axis)
        if (cloud.length(axis) == 0 && --left == 0) break;
      p[axis] = size[static_cast<std::size_t>(axis)] * 0.5;
    }
    cloud.points.push_back(p);
  }
  return cloud;
}

TEST(PeriodicEngine, LatticesAreThoseOfBruteForceInAnyTiles) {
  Scratch scratch;
  for (const auto& [dimension, side] :
       std::vector<std::pair<int, int>>{{2, 1}, {2, 3}, {2, 8}, {3, 1}, {3, 2}, {3, 5}}) {
    const Periodic given = lattice(dimension, side, 8);
    const auto expected = periodic_delaunay(expected_cloud(given));
    for (const std::uint32_t tiles : {1u, 2u, 7u}) {
      const fs::path out = scratch.run(given, with_tiles(tiles));
      EXPECT_EQ(difference(expected, cells_of(out)), "") << dimension << "D, side " << side << ", tiles " << tiles;
      EXPECT_EQ(proof_of(out, true), "") << dimension << "D, side " << side << ", tiles " << tiles;
    }
  }
}

TEST(PeriodicEngine, RandomCloudsAreThoseOfBruteForceAndAreProved) {
  Scratch scratch;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    std::mt19937_64 rng(seed);
    const Periodic given = random_periodic(rng);
    const PeriodicCloud cloud = expected_cloud(given);
    const int copies = cloud.points.size() < 10 ? 5 : 3;
    EngineOptions options =
        with_tiles(1 + static_cast<std::uint32_t>(rng() % 9), rng() % 3 == 0 ? StoreAs::points : StoreAs::cells);
    options.partition =
        std::array{PartitionKind::kdtree, PartitionKind::grid, PartitionKind::octree, PartitionKind::random}[rng() % 4];
    options.keep = rng() % 2 == 0 ? TileRetention::reduced : TileRetention::whole;
    options.neighbors = rng() % 4 != 0;
    if (rng() % 3 == 0) options.memory_bytes = 1;
    const fs::path out = scratch.run(given, options);
    const std::string what = "seed " + std::to_string(seed) + ", " + text_of(options);
    EXPECT_EQ(difference(periodic_delaunay(cloud, copies), cells_of(out)), "") << what;
    EXPECT_EQ(proof_of(out, seed % 5 == 0), "") << what;
    if (HasFailure()) return;
  }
}

TEST(PeriodicEngine, TheDigestDoesNotDependOnTiles) {
  Scratch scratch;
  std::mt19937_64 rng(5);
  std::uniform_real_distribution<double> real(0, 1);
  for (const int dimension : {2, 3}) {
    Periodic given{dimension, {1, dimension == 2 ? 2.5 : 1, 3}, {}};
    given.lengths.resize(static_cast<std::size_t>(dimension));
    for (int i = 0; i < 3000; ++i) {
      const double halo = i % 3 == 0 ? 0.02 : 1;
      given.points.push_back({0.99 + halo * real(rng), real(rng) * halo, dimension == 3 ? real(rng) * halo : 0});
    }
    std::vector<Digest> digests;
    for (const std::uint32_t tiles : {1u, 8u, 100u})
      for (const StoreAs store : {StoreAs::cells, StoreAs::points})
        digests.push_back(*read_manifest(scratch.run(given, with_tiles(tiles, store))).value().digest);
    for (const Digest& digest : digests) EXPECT_EQ(digest, digests[0]);
  }
}

// CGAL's cells as sets of ids with offsets. Points are in general position, so ties do not matter.
template <class Triangulation, class Place>
std::vector<PeriodicCell> cells_by_cgal(const Triangulation& t, const std::map<Place, PointId>& ids, int corners) {
  std::vector<PeriodicCell> cells;
  const auto add = [&](const auto& handle) {
    PeriodicCell cell{};
    for (int i = 0; i < corners; ++i) {
      const auto periodic = t.periodic_point(handle, i);
      PeriodOffset o{{periodic.second[0], periodic.second[1], 0}};
      if constexpr (requires { periodic.second.z(); }) o.by[2] = periodic.second.z();
      cell[static_cast<std::size_t>(i)] = {ids.at(periodic.first), o};
    }
    const auto end = cell.begin() + corners;
    const PeriodOffset first = std::min_element(cell.begin(), end)->second;
    for (auto v = cell.begin(); v != end; ++v) v->second = v->second - first;
    std::sort(cell.begin(), end);
    cells.push_back(cell);
  };
  if constexpr (requires { t.cells_begin(); }) {
    for (auto c = t.cells_begin(); c != t.cells_end(); ++c) add(c);
  } else {
    for (auto f = t.faces_begin(); f != t.faces_end(); ++f) add(f);
  }
  std::sort(cells.begin(), cells.end());
  return cells;
}

TEST(PeriodicEngine, CellsAreThoseOfCgalWhereItNeedsOneSheet) {
  Scratch scratch;
  for (const int dimension : {2, 3}) {
    std::mt19937_64 rng(static_cast<std::uint64_t>(dimension));
    Periodic given{dimension, std::vector<double>(static_cast<std::size_t>(dimension), 1), {}};
    for (int i = 0; i < 1500; ++i) {
      const auto real = [&] { return std::ldexp(static_cast<double>(rng() >> 13), -51); };
      given.points.push_back({real(), real(), dimension == 3 ? real() : 0});
    }
    const auto got = cells_of(scratch.run(given, with_tiles(6)));
    if (dimension == 3) {
      using Traits = CGAL::Periodic_3_Delaunay_triangulation_traits_3<K>;
      CGAL::Periodic_3_Delaunay_triangulation_3<Traits> t(CGAL::Iso_cuboid_3<K>(0, 0, 0, 1, 1, 1));
      std::map<K::Point_3, PointId> ids;
      for (std::size_t i = 0; i < given.points.size(); ++i) {
        const K::Point_3 p(given.points[i].x, given.points[i].y, given.points[i].z);
        t.insert(p);
        ids[p] = PointId{i};
      }
      ASSERT_TRUE(t.is_triangulation_in_1_sheet());
      t.convert_to_1_sheeted_covering();
      EXPECT_EQ(difference(cells_by_cgal(t, ids, 4), got), "");
    } else {
      using Traits = CGAL::Periodic_2_Delaunay_triangulation_traits_2<K>;
      CGAL::Periodic_2_Delaunay_triangulation_2<Traits> t(CGAL::Iso_rectangle_2<K>(0, 0, 1, 1));
      std::map<K::Point_2, PointId> ids;
      for (std::size_t i = 0; i < given.points.size(); ++i) {
        const K::Point_2 p(given.points[i].x, given.points[i].y);
        t.insert(p);
        ids[p] = PointId{i};
      }
      ASSERT_TRUE(t.is_triangulation_in_1_sheet());
      t.convert_to_1_sheeted_covering();
      EXPECT_EQ(difference(cells_by_cgal(t, ids, 3), got), "");
    }
  }
}

// A sound result, and what is needed to damage it with checksums that are right.
struct Sound {
  Scratch scratch;
  fs::path out;
  std::vector<TileMesh> meshes;
  Manifest manifest;

  explicit Sound(const Periodic& given, std::uint32_t tiles = 3)
      : out(scratch.run(given, with_tiles(tiles))), meshes(meshes_of(out)), manifest(read_manifest(out).value()) {}

  // What verify() says when tile `i` is another mesh, and the manifest is changed.
  std::string with(std::size_t i, const TileMesh& mesh, const std::function<void(Manifest&)>& change = {}) {
    const TileId tile = manifest.tiles[i].tile;
    const auto entry = write_tile(out, tile, mesh, {}, {});
    EXPECT_TRUE(entry) << entry.error().where;
    Manifest changed = manifest;
    changed.tiles[i] = entry.value();
    if (change) change(changed);
    EXPECT_TRUE(finish_store(out, changed, std::span<const DuplicatePair>{}));
    return proof_of(out);
  }
};

Periodic uniform(int dimension, int points, std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  std::uniform_real_distribution<double> real(0, 4);
  Periodic cloud{dimension, std::vector<double>(static_cast<std::size_t>(dimension), 4), {}};
  for (int i = 0; i < points; ++i) cloud.points.push_back({real(rng), real(rng), dimension == 3 ? real(rng) : 0});
  return cloud;
}

std::size_t first_image(const TileMesh& mesh) {
  return static_cast<std::size_t>(
      std::find_if(mesh.offsets.begin(), mesh.offsets.end(), [](std::uint8_t code) { return code != 0; }) -
      mesh.offsets.begin());
}

void expect_words(const std::string& said, const std::string& words) {
  EXPECT_NE(said.find(words), std::string::npos) << said;
}

TEST(PeriodicVerify, RefusesWhatIsNotTheTriangulation) {
  for (const int dimension : {2, 3}) {
    Sound sound(uniform(dimension, 60, 1));
    const TileMesh& mesh = sound.meshes[0];
    EXPECT_EQ(sound.with(0, mesh), "");
    const std::size_t image = first_image(mesh);
    ASSERT_LT(image, mesh.points.size());

    TileMesh moved = mesh;
    moved.offsets[image] = static_cast<std::uint8_t>(image::code(PeriodOffset{} - image::offset(mesh.offsets[image])));
    expect_words(sound.with(0, moved), "does not lie whole periods from a place");

    moved = mesh;
    moved.points[image].x += 0.25;
    EXPECT_NE(sound.with(0, moved), "");

    TileMesh fewer = mesh;
    fewer.cell_ghost[static_cast<std::size_t>(std::find(mesh.cell_ghost.begin(), mesh.cell_ghost.end(), 0) -
                                              mesh.cell_ghost.begin())] = 1;
    expect_words(sound.with(0, fewer), "main");

    TileMesh all = mesh;
    for (auto& ghost : all.cell_ghost) ghost = 0;
    EXPECT_NE(sound.with(0, all), "");

    TileMesh turned = mesh;
    std::swap(turned.cells[0], turned.cells[1]);
    std::swap(turned.neighbors[0], turned.neighbors[1]);
    expect_words(sound.with(0, turned), "is not positively oriented");

    const auto twice_as_long = [](Manifest& m) {
      const auto at = m.partition.find("\"period\":[4.0");
      ASSERT_NE(at, std::string::npos) << m.partition;
      m.partition.replace(at + 10, 3, "8.0");
    };
    expect_words(sound.with(0, mesh, twice_as_long), "does not lie whole periods from a place");
    const auto without = [](Manifest& m) {
      m.format_version = unchanged_format;
      const auto at = m.partition.find("\"period\"");
      m.partition.erase(at, m.partition.find(']', at) + 2 - at);
    };
    EXPECT_NE(sound.with(0, mesh, without), "");
    EXPECT_EQ(sound.with(0, mesh), "");
  }
}

// Mirrored, the triangulation of a lattice breaks all ties the other way.
TEST(PeriodicVerify, RefusesTiesThatAreBrokenTheOtherWay) {
  Sound sound(lattice(2, 1, 4), 1);
  TileMesh mesh = sound.meshes[0];
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    mesh.points[v].x = -mesh.points[v].x + 0.0;
    PeriodOffset o = image::offset(mesh.offsets[v]);
    o.by[0] = -o.by[0];
    mesh.offsets[v] = static_cast<std::uint8_t>(image::code(o));
  }
  for (std::size_t c = 0; c < mesh.cells.size(); c += 3) {
    std::swap(mesh.cells[c + 1], mesh.cells[c + 2]);
    std::swap(mesh.neighbors[c + 1], mesh.neighbors[c + 2]);
  }
  expect_words(sound.with(0, mesh), "is not Delaunay");
}

TEST(PeriodicVerify, RefusesACellThatIsGoneOrThereTwice) {
  Sound sound(uniform(2, 40, 3), 1);
  TileMesh mesh = sound.meshes[0];
  const auto cell = static_cast<std::ptrdiff_t>(mesh.cell_ghost.size()) - 1;
  TileMesh twice = mesh;
  twice.cells.insert(twice.cells.end(), mesh.cells.begin() + 3 * cell, mesh.cells.begin() + 3 * cell + 3);
  twice.neighbors.insert(twice.neighbors.end(), mesh.neighbors.begin() + 3 * cell,
                         mesh.neighbors.begin() + 3 * cell + 3);
  twice.cell_ghost.push_back(mesh.cell_ghost.back());
  EXPECT_NE(sound.with(0, twice), "");
  mesh.cells.resize(mesh.cells.size() - 3);
  mesh.neighbors.resize(mesh.neighbors.size() - 3);
  mesh.cell_ghost.pop_back();
  for (auto& n : mesh.neighbors)
    if (n == cell) n = -1;
  EXPECT_NE(sound.with(0, mesh), "");
}

}  // namespace
}  // namespace tessera::testing
