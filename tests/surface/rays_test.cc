// Rays through tiles against a look at every facet there is, in whole numbers.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <limits>
#include <map>
#include <random>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "src/surface/line.h"
#include "src/surface/ray_caster.h"
#include "src/surface/region.h"
#include "tests/store/sample_result.h"

namespace tessera::surface {
namespace {

using Whole = std::array<std::int64_t, 3>;
Whole whole(const Point& p) {
  return {static_cast<std::int64_t>(p.x), static_cast<std::int64_t>(p.y), static_cast<std::int64_t>(p.z)};
}
Whole minus(const Whole& a, const Whole& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Whole cross(const Whole& a, const Whole& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
std::int64_t dot(const Whole& a, const Whole& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
// Of (s + (e, e^2, e^3) - from) times the vector: its terms in e, one after the other.
int sign(const Whole& s, const Whole& from, const Whole& vector) {
  for (const std::int64_t term : {dot(minus(s, from), vector), vector[0], vector[1], vector[2]})
    if (term != 0) return term > 0 ? 1 : -1;
  return 0;
}

// What rays have given to arcs and cells, by the cell's vertices, and the corner opposite the arc's facet.
struct Said {
  std::map<std::pair<CellName, PointId>, std::uint64_t> arcs;
  std::map<CellName, std::int64_t> excess;
  friend bool operator==(const Said&, const Said&) = default;
};

SurfaceTile tile_of(TileId id, const TileMesh& mesh) {
  StoredTile stored;
  stored.mesh = mesh;
  SurfaceTile tile = SurfaceTile::make(id, "a tile", std::move(stored)).value();
  tile.begin_weights();
  return tile;
}

constexpr double scale = 1e-5;  // so that every facet that is crossed gets a full vote

// With all tiles and mail between them, in any order.
Said cast(const std::vector<TileMesh>& meshes, const std::vector<Point>& sensors, std::mt19937_64& random,
          std::uint64_t& handed_over) {
  Energy energy;
  energy.ray_length = std::numeric_limits<double>::infinity();
  std::vector<SurfaceTile> tiles;
  std::uint64_t cells = 0;
  for (const TileMesh& mesh : meshes) cells += static_cast<std::uint64_t>(std::ranges::count(mesh.cell_ghost, 0));
  for (std::uint32_t t = 0; t < meshes.size(); ++t) tiles.push_back(tile_of(TileId{t}, meshes[t]));
  std::vector<std::pair<TileId, RayRecord>> mail;
  const auto take = [&](RayCaster& caster) {
    for (auto& leaving : caster.take_leaving()) mail.push_back(leaving);
  };
  for (SurfaceTile& tile : tiles) {
    RayCaster caster(tile, energy, cells);
    for (std::int32_t v = 0; v < tile.own_vertices(); ++v)
      EXPECT_TRUE(caster.cast(v, sensors[tile.id(v).value], scale, full_vote));
    take(caster);
  }
  while (!mail.empty()) {
    std::swap(mail[random() % mail.size()], mail.back());
    const auto [to, ray] = mail.back();
    mail.pop_back();
    ++handed_over;
    RayCaster caster(tiles[to.value], energy, cells);
    const auto status = caster.go_on(ray);
    EXPECT_TRUE(status) << status.error().where;
    take(caster);
  }
  for (SurfaceTile& tile : tiles)
    give_sums(
        tile, [&](TileId to, const SumRecord& sum) { EXPECT_TRUE(take_sum(tiles[to.value], sum)); },
        [&](TileId to, const VoteRecord& vote) { EXPECT_TRUE(take_vote(tiles[to.value], vote)); });
  Said said;
  for (SurfaceTile& tile : tiles)
    for (std::int32_t cell = 0; cell < tile.cells(); ++cell) {
      for (std::size_t k = 0; k < 4; ++k)
        if (const auto weight = tile.arc(cell, k); weight != 0)
          said.arcs[{tile.name(cell), tile.id(tile.vertex(cell, k))}] += weight;
      if (const auto votes = tile.excess(cell); votes != 0) said.excess[tile.name(cell)] += votes;
    }
  std::erase_if(said.excess, [](const auto& entry) { return entry.second == 0; });
  return said;
}

class Looker {
 public:
  explicit Looker(const TileMesh& mesh) : tile_(tile_of(TileId{0}, mesh)) {}

  Said look(const std::vector<Point>& sensors) {
    Said said;
    for (std::int32_t v = 0; v < tile_.own_vertices(); ++v) look(v, whole(sensors[tile_.id(v).value]), said);
    std::erase_if(said.excess, [](const auto& entry) { return entry.second == 0; });
    return said;
  }

 private:
  Whole at(std::int32_t v) const { return whole(tile_.point(v)); }

  // Whether the line from p to s passes inside of the facet; from = 1: on the way to s, -1: away from it.
  static bool passes(const Whole& p, const Whole& s, const std::array<Whole, 3>& f, int from) {
    for (std::size_t i = 0; i < 3; ++i)
      if (sign(s, p, cross(minus(f[i], p), minus(f[(i + 1) % 3], p))) != from) return false;
    return true;
  }

  void look(std::int32_t v, const Whole& s, Said& said) {
    const Whole p = at(v);
    for (std::int32_t cell = 0; cell < tile_.cells(); ++cell) {
      bool sensor_inside = true;
      for (std::size_t k = 0; k < 4; ++k) {
        std::array<Whole, 3> f;
        for (std::size_t i = 0; i < 3; ++i) f[i] = at(tile_.vertex(cell, facet_corners[k][i]));
        const Whole normal = cross(minus(f[1], f[0]), minus(f[2], f[0]));  // outwards
        const int sensor = sign(s, f[0], normal);
        sensor_inside = sensor_inside && sensor < 0;
        const std::int64_t side = dot(minus(p, f[0]), normal);
        if (side < 0 && tile_.vertex(cell, k) == v && passes(p, s, f, -1)) said.excess[tile_.name(cell)] -= full_vote;
        if (side >= 0 || sensor <= 0 || !passes(p, s, f, 1)) continue;
        const std::int32_t across = tile_.neighbor(cell, k);
        if (across < 0) {
          said.excess[tile_.name(cell)] += full_vote;
          continue;
        }
        said.arcs[{tile_.name(cell), tile_.id(tile_.vertex(cell, k))}] += full_vote;
        said.excess[tile_.name(cell)] += full_vote;
        said.excess[tile_.name(across)] -= full_vote;
      }
      if (sensor_inside) said.excess[tile_.name(cell)] += full_vote;
    }
  }

  SurfaceTile tile_;
};

struct Cloud {
  std::vector<Point> points, sensors;
};

// Lattices, stacks and walls, seen along their planes, from points of lines through others, from inside and outside.
Cloud random_cloud(std::mt19937_64& random) {
  const auto below = [&](std::int64_t n) { return static_cast<double>(random() % static_cast<std::uint64_t>(n)); };
  const std::int64_t size[3] = {2 + static_cast<std::int64_t>(random() % 4),
                                2 + static_cast<std::int64_t>(random() % 4),
                                2 + static_cast<std::int64_t>(random() % 4)};
  std::set<Point> points;
  while (points.size() < 5 || std::ssize(points) < std::min<std::int64_t>(size[0] * size[1] * size[2], 40))
    points.insert({below(size[0]), below(size[1]), below(size[2])});
  Cloud cloud{{points.begin(), points.end()}, {}};
  std::shuffle(cloud.points.begin(), cloud.points.end(), random);
  const auto kind = random() % 5;
  const Point one{below(9) - 2, below(9) - 2, below(9) - 2};
  for (const Point& p : cloud.points) {
    Point s = one;
    if (kind == 1) s = {p.x, p.y, 20};
    if (kind == 2) s = cloud.points[random() % cloud.points.size()];
    if (kind == 3) s = {below(9) - 2, below(9) - 2, below(9) - 2};
    if (kind == 4) s = {p.x + 3 * (below(3) - 1), p.y + 3 * (below(3) - 1), p.z + 3 * (below(3) - 1)};
    while (s == p) s = {below(9) - 2, below(9) - 2, below(9) - 2};
    cloud.sensors.push_back(s);
  }
  return cloud;
}

int times(const char* name, int otherwise) {
  const char* text = std::getenv(name);
  return text == nullptr ? otherwise : std::atoi(text);
}

TEST(Rays, CrossTheFacetsThatALookAtAllOfThemFinds) {
  std::uint64_t rays = 0, handed_over = 0;
  const int seeds = times("RAY_SEEDS", 600);
  for (int seed = 0; seed < seeds; ++seed) {
    std::mt19937_64 random(static_cast<std::uint64_t>(seed));
    const Cloud cloud = random_cloud(random);
    const auto one = test::sample_tiles(cloud.points, 3, 1);
    if (one[0].cell_ghost.empty()) continue;  // all in one plane
    const Said wanted = Looker(one[0]).look(cloud.sensors);
    const std::uint32_t tiles = 1 + static_cast<std::uint32_t>(random() % 6);
    const auto partition = random();
    const auto meshes = test::sample_tiles(cloud.points, 3, tiles, [&](std::size_t i) {
      return static_cast<std::uint32_t>((i * 2654435761u ^ partition) / 7 % tiles);
    });
    const Said said = cast(meshes, cloud.sensors, random, handed_over);
    ASSERT_EQ(said.arcs, wanted.arcs) << "seed " << seed;
    ASSERT_EQ(said.excess, wanted.excess) << "seed " << seed;
    rays += cloud.points.size();
  }
  EXPECT_GT(handed_over, rays / 8);
}

// Two cells that are each other's neighbours across all of their facets.
TEST(Rays, DoNotGoRoundForEver) {
  auto mesh = test::sample_tiles(test::sample_points(test::Shape::uniform, 3, 30), 3, 1).front();
  for (std::size_t i = 0; i < mesh.neighbors.size(); ++i)
    if (mesh.neighbors[i] >= 0) mesh.neighbors[i] = static_cast<std::int32_t>(i / 4) == 0 ? 1 : 0;
  SurfaceTile tile = tile_of(TileId{0}, mesh);
  Energy energy;
  energy.ray_length = std::numeric_limits<double>::infinity();
  RayCaster caster(tile, energy, mesh.cell_ghost.size());
  bool refused = false;
  for (std::int32_t v = 0; v < tile.own_vertices(); ++v)
    refused = !caster.cast(v, {0.5, 0.5, 100}, scale, full_vote) || refused;
  EXPECT_TRUE(refused);
}

TEST(Rays, ThePerturbationDecidesWhatPlanesLeaveOpen) {
  const Point p{0, 0, 0}, s{0, 0, 5}, a{1, 0, 1}, b{0, 0, 2};
  EXPECT_NE(side_of_line(p, s, a, b), 0);
  EXPECT_EQ(side_of_line(p, s, a, b), -side_of_line(p, s, b, a));
  EXPECT_EQ(side_of_line(p, s, {0, 0, 1}, {0, 0, 2}), 0);
  EXPECT_EQ(is_beyond({0, 0, 5}, {1, 0, 5}, {0, 1, 5}, s), true);
  EXPECT_EQ(is_beyond({0, 0, 5}, {0, 1, 5}, {1, 0, 5}, s), false);
}

}  // namespace
}  // namespace tessera::surface
