#include "tests/cut/whole_graph.h"

#include <algorithm>

namespace tessera::cut {

bool WholeGraph::join(std::uint32_t a, std::uint32_t b, std::uint32_t there, std::uint32_t back) {
  const auto free = [&](std::uint32_t cell) {
    std::uint32_t facet = 0;
    while (facet < 4 && sides[cell][facet].cell != nobody) ++facet;
    return facet;
  };
  const std::uint32_t at_a = free(a), at_b = free(b);
  if (a == b || at_a == 4 || at_b == 4) return false;
  sides[a][at_a] = {b, at_b, there};
  sides[b][at_b] = {a, at_a, back};
  return true;
}

CutGraph WholeGraph::as_one() const {
  CutGraph graph;
  graph.excess.assign(excess.begin(), excess.end());
  for (const auto& four : sides)
    for (const Side& side : four) {
      graph.capacity.push_back(side.capacity);
      graph.back.push_back(side.cell == nobody ? no_arc : 4 * side.cell + side.facet);
    }
  return graph;
}

namespace {

std::int64_t random_excess(std::mt19937_64& random) {
  switch (random() % 5) {
    case 0:
    case 1:
      return 0;
    case 2:
      return static_cast<std::int64_t>(1 + random() % 9);
    case 3:
      return -static_cast<std::int64_t>(1 + random() % 9);
    default:
      return random() % 5 == 0 ? infinite_terminal : 0;
  }
}

std::uint32_t random_capacity(std::mt19937_64& random) {
  const auto kind = random() % 6;
  return static_cast<std::uint32_t>(kind < 4 ? kind : random() % 10);
}

}  // namespace

WholeGraph random_graph(std::mt19937_64& random, std::uint32_t cells) {
  WholeGraph graph;
  graph.sides.resize(cells);
  for (std::uint32_t cell = 0; cell < cells; ++cell) graph.excess.push_back(random_excess(random));
  for (std::uint32_t edges = 0; edges < 2 * cells; ++edges)
    graph.join(static_cast<std::uint32_t>(random() % cells), static_cast<std::uint32_t>(random() % cells),
               random_capacity(random), random_capacity(random));
  return graph;
}

WholeGraph grid_graph(std::mt19937_64& random, std::uint32_t width, std::uint32_t height) {
  WholeGraph graph;
  graph.sides.resize(std::size_t{width} * height);
  for (std::size_t cell = 0; cell < graph.sides.size(); ++cell) graph.excess.push_back(random_excess(random));
  for (std::uint32_t y = 0; y < height; ++y)
    for (std::uint32_t x = 0; x < width; ++x) {
      const std::uint32_t cell = y * width + x;
      if (x + 1 < width) graph.join(cell, cell + 1, random_capacity(random), random_capacity(random));
      if (y + 1 < height) graph.join(cell, cell + width, random_capacity(random), random_capacity(random));
    }
  return graph;
}

std::int64_t cost(const WholeGraph& graph, const std::vector<bool>& source) {
  std::int64_t sum = 0;
  for (std::uint32_t cell = 0; cell < graph.cells(); ++cell) {
    sum +=
        source[cell] ? std::max<std::int64_t>(0, -graph.excess[cell]) : std::max<std::int64_t>(0, graph.excess[cell]);
    if (!source[cell]) continue;
    for (const auto& side : graph.sides[cell])
      if (side.cell != WholeGraph::nobody && !source[side.cell]) sum += side.capacity;
  }
  return sum;
}

std::vector<bool> smallest_by_trying(const WholeGraph& graph) {
  const std::uint32_t n = graph.cells();
  std::int64_t best = -1;
  std::vector<bool> smallest(n), source(n);
  for (std::uint32_t mask = 0; mask < 1u << n; ++mask) {
    for (std::uint32_t cell = 0; cell < n; ++cell) source[cell] = mask >> cell & 1u;
    const std::int64_t found = cost(graph, source);
    if (best < 0 || found < best) {
      best = found;
      smallest = source;
    } else if (found == best) {
      for (std::uint32_t cell = 0; cell < n; ++cell) smallest[cell] = smallest[cell] && source[cell];
    }
  }
  return smallest;
}

std::vector<bool> smallest_by_augmenting(const WholeGraph& graph) {
  CutGraph left = graph.as_one();
  std::vector<Arc> way(graph.cells());
  while (true) {
    std::vector<bool> seen(graph.cells());
    std::vector<std::uint32_t> queue;
    std::uint32_t end = WholeGraph::nobody;
    for (std::uint32_t cell = 0; cell < graph.cells(); ++cell)
      if (left.excess[cell] > 0) {
        seen[cell] = true;
        way[cell] = no_arc;
        queue.push_back(cell);
      }
    for (std::size_t i = 0; i < queue.size() && end == WholeGraph::nobody; ++i) {
      if (left.excess[queue[i]] < 0) end = queue[i];
      for (Arc arc = 4 * queue[i]; arc < 4 * queue[i] + 4; ++arc) {
        if (left.capacity[arc] == 0 || seen[left.back[arc] >> 2u]) continue;
        seen[left.back[arc] >> 2u] = true;
        way[left.back[arc] >> 2u] = arc;
        queue.push_back(left.back[arc] >> 2u);
      }
    }
    if (end == WholeGraph::nobody) return seen;
    std::int64_t flow = -left.excess[end];
    std::uint32_t cell = end;
    for (; way[cell] != no_arc; cell = way[cell] >> 2u) flow = std::min<std::int64_t>(flow, left.capacity[way[cell]]);
    flow = std::min(flow, left.excess[cell]);
    for (cell = end; way[cell] != no_arc; cell = way[cell] >> 2u)
      left.push(way[cell], static_cast<std::uint32_t>(flow));
  }
}

std::vector<bool> as_bools(const CellSet& set, std::uint32_t cells) {
  std::vector<bool> bools(cells);
  for (std::uint32_t cell = 0; cell < cells; ++cell) bools[cell] = set.contains(cell);
  return bools;
}

}  // namespace tessera::cut
