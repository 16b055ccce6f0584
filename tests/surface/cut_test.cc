// The labels of a result in many tiles against a flow, by another library, through the graph of the whole.
#include <gtest/gtest.h>

#include <algorithm>
#include <boost/graph/adjacency_list.hpp>
#include <boost/graph/boykov_kolmogorov_max_flow.hpp>
#include <queue>
#include <random>
#include <utility>
#include <vector>

#include "src/surface/ray_caster.h"
#include "src/surface/region.h"
#include "tests/store/sample_result.h"
#include "tests/surface/triangles_of_result.h"

namespace tessera::surface {
namespace {

using Traits = boost::adjacency_list_traits<boost::vecS, boost::vecS, boost::directedS>;
using Graph = boost::adjacency_list<
    boost::vecS, boost::vecS, boost::directedS,
    boost::property<boost::vertex_color_t, boost::default_color_type,
                    boost::property<boost::vertex_distance_t, std::int64_t,
                                    boost::property<boost::vertex_predecessor_t, Traits::edge_descriptor>>>,
    boost::property<boost::edge_capacity_t, std::int64_t,
                    boost::property<boost::edge_residual_capacity_t, std::int64_t,
                                    boost::property<boost::edge_reverse_t, Traits::edge_descriptor>>>>;

void join(Graph& graph, std::size_t a, std::size_t b, std::int64_t there, std::int64_t back) {
  const auto one = boost::add_edge(a, b, graph).first, other = boost::add_edge(b, a, graph).first;
  boost::put(boost::edge_capacity, graph, one, there);
  boost::put(boost::edge_capacity, graph, other, back);
  boost::put(boost::edge_reverse, graph, one, other);
  boost::put(boost::edge_reverse, graph, other, one);
}

// The cells that residual arcs lead to from the source.
std::vector<bool> smallest_source_set(const cut::CutGraph& from) {
  const std::size_t cells = from.cells(), source = cells, sink = cells + 1;
  Graph graph(cells + 2);
  for (std::uint32_t cell = 0; cell < cells; ++cell) {
    const std::int64_t excess = from.excess[cell];
    join(graph, source, cell, std::max<std::int64_t>(excess, 0), 0);
    join(graph, cell, sink, std::max<std::int64_t>(-excess, 0), 0);
    for (cut::Arc arc = 4 * cell; arc < 4 * cell + 4; ++arc)
      if (from.back[arc] != cut::no_arc && arc < from.back[arc])
        join(graph, cell, from.back[arc] >> 2u, from.capacity[arc], from.capacity[from.back[arc]]);
  }
  boost::boykov_kolmogorov_max_flow(graph, source, sink);
  std::vector<bool> reached(cells + 2, false);
  std::queue<std::size_t> queue;
  reached[source] = true;
  queue.push(source);
  while (!queue.empty()) {
    const std::size_t at = queue.front();
    queue.pop();
    const auto [begin, end] = boost::out_edges(at, graph);
    for (auto edge = begin; edge != end; ++edge) {
      const std::size_t to = boost::target(*edge, graph);
      if (reached[to] || boost::get(boost::edge_residual_capacity, graph, *edge) == 0) continue;
      reached[to] = true;
      queue.push(to);
    }
  }
  EXPECT_FALSE(reached[sink]);
  return reached;
}

std::vector<IdTriangle> expected(const std::vector<Point>& points, const SensorOptions& where, const Energy& energy,
                                 double sigma, const CutRule& rule) {
  StoredTile stored;
  stored.mesh = test::sample_tiles(points, 3, 1).front();
  Bounds bounds;
  for (const Point& p : points) bounds.add(p);
  const Sensors sensors = Sensors::make(where, {}, bounds).value();
  SurfaceTile tile = SurfaceTile::make(TileId{0}, "all", std::move(stored)).value();
  tile.begin_weights();
  RayCaster caster(tile, energy, static_cast<std::uint64_t>(tile.cells()));
  for (std::int32_t v = 0; v < tile.own_vertices(); ++v) {
    const auto sensor = sensors.of(tile.point(v), tile.id(v), nullptr).value();
    EXPECT_TRUE(caster.cast(v, sensor->at, sigma, full_vote));
  }
  const Region region = region_of(tile, energy, rule, {}).value();
  const auto source = smallest_source_set(region.graph);
  std::vector<IdTriangle> triangles;
  const auto outside = [&](std::int32_t cell) {
    return cell < 0 || source[static_cast<std::size_t>(cell)] == rule.unknown_inside;
  };
  for (std::int32_t cell = 0; cell < tile.cells(); ++cell)
    for (std::size_t k = 0; k < 4; ++k) {
      if (outside(cell) || !outside(tile.neighbor(cell, k))) continue;
      const auto facet = tile.facet(cell, k);
      triangles.push_back(of_ids(facet[0].id, facet[1].id, facet[2].id));
    }
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

TEST(SurfaceCut, IsTheSmallestOneThatAnotherLibraryFinds) {
  std::uint64_t undecided = 0, found_in_all = 0;
  for (unsigned seed = 0; seed < 24; ++seed) {
    std::mt19937_64 random(seed);
    const auto shape = static_cast<test::Shape>(seed % 4);
    const auto points = test::sample_points(shape, 3, 100 + random() % 500, seed);
    Bounds bounds;
    for (const Point& p : points) bounds.add(p);
    const double size = bounds.hi.x - bounds.lo.x;
    SensorOptions sensors;
    if (seed % 3 == 1)
      sensors = {.kind = SensorOptions::Kind::positions,
                 .positions = {{bounds.lo.x - size, bounds.lo.y - size / 3, bounds.hi.z + size / 2},
                               {bounds.hi.x + size / 7, bounds.hi.y + size, bounds.hi.z + size / 5}}};
    Energy energy{.lambda = static_cast<double>(random() % 40) / 4,
                  .alpha = 32,
                  .ray_length = 3.0 + seed % 8,
                  .sigma = size / static_cast<double>(5 + random() % 40)};
    const CutRule rule{.lower_inside = seed % 5 != 0, .unknown_inside = seed % 7 != 0};
    const auto wanted = expected(points, sensors, energy, energy.sigma, rule);
    const std::uint32_t tiles = 2 + static_cast<std::uint32_t>(random() % 5);
    const test::TemporaryFolder folder;
    test::store_sample(folder.path() / "out", test::sample_tiles(points, 3, tiles));
    const Triangles found = triangles_of(
        folder.path() / "out", sensors,
        {.energy = energy, .rule = rule, .boundary = {}, .memory_bytes = std::uint64_t{1} << 30, .threads = 2});
    ASSERT_EQ(found.main, wanted) << "seed " << seed;
    undecided += found.undecided;
    found_in_all += found.main.size();
  }
  EXPECT_GT(undecided, 0u);
  EXPECT_GT(found_in_all, 1000u);
}

}  // namespace
}  // namespace tessera::surface
