#include "src/surface/cut/reduce.h"

#include "src/base/check.h"

namespace tessera::cut {

CutGraph with_borders_to_sink(CutGraph graph) {
  for (const CutGraph::Border& border : graph.borders) graph.excess[border.arc >> 2u] -= graph.capacity[border.arc];
  return graph;
}

CutGraph with_borders_from_source(CutGraph graph) {
  for (const CutGraph::Border& border : graph.borders) graph.excess[border.arc >> 2u] += border.capacity_in;
  return graph;
}

std::vector<Decided> decided_by(const CellSet& least, const CellSet& most, std::uint32_t cells) {
  std::vector<Decided> decided(cells, Decided::no);
  for (std::uint32_t cell = 0; cell < cells; ++cell) {
    if (least.contains(cell)) {
      decided[cell] = Decided::source;
    } else if (!most.contains(cell)) {
      decided[cell] = Decided::sink;
    }
  }
  return decided;
}

ReducedGraph kernel_of(const CutGraph& graph, const std::vector<Decided>& decided) {
  ReducedGraph kernel;
  std::vector<std::uint32_t> number(graph.cells(), ~std::uint32_t{0});
  for (std::uint32_t cell = 0; cell < graph.cells(); ++cell) {
    if (decided[cell] != Decided::no) continue;
    number[cell] = static_cast<std::uint32_t>(kernel.cells.size());
    kernel.cells.push_back(cell);
  }
  CutGraph& to = kernel.graph;
  to.excess.resize(kernel.cells.size());
  to.capacity.resize(4 * kernel.cells.size());
  to.back.resize(4 * kernel.cells.size());
  std::vector<std::uint32_t> border_number(graph.borders.size(), ~std::uint32_t{0});
  for (std::uint32_t i = 0; i < graph.borders.size(); ++i) {
    const Arc arc = graph.borders[i].arc;
    if (decided[arc >> 2u] != Decided::no) continue;
    border_number[i] = static_cast<std::uint32_t>(to.borders.size());
    to.borders.push_back({4 * number[arc >> 2u] + (arc & 3u), graph.borders[i].capacity_in});
    kernel.borders.push_back(i);
  }
  for (std::uint32_t cell = 0; cell < kernel.cells.size(); ++cell) {
    const std::uint32_t from = kernel.cells[cell];
    to.excess[cell] = graph.excess[from];
    for (std::uint32_t facet = 0; facet < 4; ++facet) {
      const Arc back = graph.back[4 * from + facet];
      const std::uint32_t out = graph.capacity[4 * from + facet];
      Arc& back_to = to.back[4 * cell + facet];
      std::uint32_t& capacity = to.capacity[4 * cell + facet];
      back_to = no_arc;
      capacity = 0;
      if (back == no_arc) continue;
      if (!is_inner(back)) {
        back_to = border_bit | border_number[back & ~border_bit];
        capacity = out;
        continue;
      }
      switch (decided[back >> 2u]) {
        case Decided::no:
          back_to = 4 * number[back >> 2u] + (back & 3u);
          capacity = out;
          break;
        case Decided::source:
          to.excess[cell] += graph.capacity[back];
          break;
        case Decided::sink:
          to.excess[cell] -= out;
          break;
      }
    }
  }
  return kernel;
}

void take_decided(ReducedGraph& kernel, const std::vector<Decided>& across) {
  CutGraph& graph = kernel.graph;
  check(across.size() == graph.borders.size(), "each border of a kernel is asked about");
  std::uint32_t stay = 0;
  for (std::uint32_t i = 0; i < across.size(); ++i) {
    const CutGraph::Border border = graph.borders[i];
    if (across[i] == Decided::no) {
      graph.back[border.arc] = border_bit | stay;
      kernel.borders[stay] = kernel.borders[i];
      graph.borders[stay++] = border;
      continue;
    }
    std::int64_t& excess = graph.excess[border.arc >> 2u];
    if (across[i] == Decided::source) excess += border.capacity_in;
    if (across[i] == Decided::sink) excess -= graph.capacity[border.arc];
    graph.back[border.arc] = no_arc;
    graph.capacity[border.arc] = 0;
  }
  graph.borders.resize(stay);
  kernel.borders.resize(stay);
}

}  // namespace tessera::cut
