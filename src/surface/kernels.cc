#include <numeric>
#include <string>
#include <utility>

#include "src/surface/cut/certificate.h"
#include "src/surface/cut/search_trees.h"
#include "src/surface/region.h"

namespace tessera::surface {

namespace {

// Computes a maximum flow and returns its source set. `prove`: also proves it.
Result<cut::CellSet> solve(cut::CutGraph& graph, bool prove) {
  if (!prove) return cut::SearchTrees(graph).run();
  const cut::CutGraph before = graph;
  cut::CellSet source = cut::SearchTrees(graph).run();
  const std::string why = cut::why_no_proof(before, graph, source);
  if (!why.empty()) return error(Errc::internal, "a cut is not proved: " + why);
  return source;
}

}  // namespace

Result<ReducedRegion> kernel_of(CutRegion region, bool prove) {
  cut::CutGraph& graph = region.graph;
  BOOST_OUTCOME_TRY(flown, solve(graph, prove));
  std::vector<cut::Decided> decided;
  if (graph.borders.empty()) {
    decided = cut::decided_by(flown, graph.cells());
  } else {
    cut::CutGraph least = cut::with_borders_to_sink(graph);
    BOOST_OUTCOME_TRY(sources, solve(least, prove));
    least = {};
    cut::CutGraph most = cut::with_borders_from_source(graph);
    BOOST_OUTCOME_TRY(no_sinks, solve(most, prove));
    decided = cut::decided_by(sources, no_sinks, graph.cells());
  }
  ReducedRegion out;
  out.kernel = cut::kernel_of(graph, decided);
  for (std::uint32_t& border : out.kernel.borders) border = region.borders[border];
  out.names = std::move(region.names);
  out.at_border = std::move(region.at_border);
  for (std::size_t i = 0; i < graph.borders.size(); ++i)
    out.at_border[region.borders[i]] = decided[graph.borders[i].arc >> 2u];
  out.sources = cut::CellSet(graph.cells());
  out.open = cut::CellSet(graph.cells());
  for (std::uint32_t cell = 0; cell < graph.cells(); ++cell) {
    if (decided[cell] == cut::Decided::source) out.sources.insert(cell);
    if (decided[cell] == cut::Decided::no) out.open.insert(cell);
  }
  return out;
}

ReducedRegion all_of(CutRegion region) {
  const std::uint32_t cells = region.graph.cells();
  ReducedRegion out;
  out.kernel.cells.resize(cells);
  std::iota(out.kernel.cells.begin(), out.kernel.cells.end(), std::uint32_t{0});
  out.kernel.graph = std::move(region.graph);
  out.kernel.borders = std::move(region.borders);
  out.names = std::move(region.names);
  out.at_border = std::move(region.at_border);
  out.sources = cut::CellSet(cells);
  out.open = cut::CellSet(cells);
  for (std::uint32_t cell = 0; cell < cells; ++cell) out.open.insert(cell);
  return out;
}

}  // namespace tessera::surface
