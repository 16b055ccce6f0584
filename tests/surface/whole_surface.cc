// The surface of a whole cloud by other means: one tile, and a flow by another library through the graph of all cells.
#include "tests/surface/whole_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <boost/graph/adjacency_list.hpp>
#include <boost/graph/boykov_kolmogorov_max_flow.hpp>
#include <queue>
#include <utility>

#include "src/surface/ray_caster.h"
#include "src/surface/region.h"
#include "tests/store/sample_result.h"

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

// Of each vertex, within a quarter and four times the median, which is cut off after nine bits of its mantissa.
std::vector<double> scales_of(SurfaceTile& tile) {
  std::vector<double> scales;
  for (std::int32_t v = 0; v < tile.own_vertices(); ++v) scales.push_back(tile.scale_of(v));
  std::vector<double> sorted = scales;
  std::sort(sorted.begin(), sorted.end());
  const double median = std::bit_cast<double>(std::bit_cast<std::uint64_t>(sorted[sorted.size() / 2]) >> 43u << 43u);
  for (double& scale : scales) scale = std::clamp(scale, median / 4, median * 4);
  return scales;
}

}  // namespace

std::vector<IdTriangle> surface_of_whole(const std::vector<Point>& points, const SensorOptions& where,
                                         const Energy& energy, const CutRule& rule) {
  StoredTile stored;
  stored.mesh = test::sample_tiles(points, 3, 1).front();
  Bounds bounds;
  for (const Point& p : points) bounds.add(p);
  const Sensors sensors = Sensors::make(where, {}, bounds).value();
  SurfaceTile tile = SurfaceTile::make(TileId{0}, "all", std::move(stored)).value();
  tile.begin_weights();
  RayCaster caster(tile, energy, static_cast<std::uint64_t>(tile.cells()));
  const std::vector<double> sigmas =
      energy.sigma > 0 ? std::vector<double>(points.size(), energy.sigma) : scales_of(tile);
  for (std::int32_t v = 0; v < tile.own_vertices(); ++v) {
    const auto sensor = sensors.of(tile.point(v), tile.id(v), nullptr).value();
    EXPECT_TRUE(caster.cast(v, sensor->at, sigmas[static_cast<std::size_t>(v)], full_vote));
  }
  const CutRegion region = region_of(tile, energy, rule, {}).value();
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

}  // namespace tessera::surface
