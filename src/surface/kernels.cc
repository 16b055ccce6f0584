#include <algorithm>
#include <string>
#include <tuple>
#include <utility>

#include "src/cut/certificate.h"
#include "src/cut/search_trees.h"
#include "src/surface/region.h"

namespace tessera::surface {

namespace {

// Runs a flow to its end.
Result<cut::CellSet> solve(cut::CutGraph& graph, bool prove) {
  if (!prove) return cut::SearchTrees(graph).run();
  const cut::CutGraph before = graph;
  cut::CellSet source = cut::SearchTrees(graph).run();
  const std::string why = cut::why_no_proof(before, graph, source);
  if (!why.empty()) return error(Errc::internal, "a cut is not proved: " + why);
  return source;
}

}  // namespace

Result<RegionKernel> kernel_of(Region region, bool prove) {
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
  RegionKernel out;
  out.kernel = cut::kernel_of(graph, decided);
  out.names = std::move(region.borders);
  for (const auto& border : graph.borders) out.at_border.push_back(decided[border.arc >> 2u]);
  out.sources = cut::CellSet(graph.cells());
  out.open = cut::CellSet(graph.cells());
  for (std::uint32_t cell = 0; cell < graph.cells(); ++cell) {
    if (decided[cell] == cut::Decided::source) out.sources.insert(cell);
    if (decided[cell] == cut::Decided::no) out.open.insert(cell);
  }
  return out;
}

std::uint64_t RegionKernel::bytes() const {
  return kernel.graph.bytes() + kernel.graph.borders.size() * sizeof(kernel.graph.borders[0]) +
         (kernel.cells.size() + kernel.borders.size()) * sizeof(std::uint32_t) + names.size() * sizeof(BorderName) +
         at_border.size() + sources.bytes() + open.bytes();
}

namespace {

// One side of a border between two regions.
struct Side {
  std::array<PointId, 3> facet;
  std::uint32_t region = 0, border = 0;
};

// By region and border: the other side of it.
Result<std::vector<std::vector<Side>>> match(const std::vector<RegionKernel>& regions, std::span<const TileId> tiles) {
  std::vector<Side> sides;
  std::vector<std::vector<Side>> others(regions.size());
  for (std::uint32_t r = 0; r < regions.size(); ++r) {
    others[r].resize(regions[r].names.size());
    for (std::uint32_t b = 0; b < regions[r].names.size(); ++b) sides.push_back({regions[r].names[b].facet, r, b});
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::tie(a.facet, a.region, a.border) < std::tie(b.facet, b.region, b.border);
  });
  for (std::size_t i = 0; i < sides.size(); i += 2) {
    const Side& a = sides[i];
    const bool pair = i + 1 < sides.size() && sides[i + 1].facet == a.facet &&
                      regions[a.region].names[a.border].to == tiles[sides[i + 1].region] &&
                      regions[sides[i + 1].region].names[sides[i + 1].border].to == tiles[a.region];
    if (!pair)
      return error(Errc::corrupt, "tile " + to_string(tiles[a.region]) + " has a border at vertex " +
                                      to_string(a.facet[0]) + " that its neighbour does not have");
    const Side& b = sides[i + 1];
    others[a.region][a.border] = b;
    others[b.region][b.border] = a;
  }
  return others;
}

}  // namespace

Result<std::vector<cut::CellSet>> solve_together(std::vector<RegionKernel>& regions, std::span<const TileId> tiles,
                                                 bool prove) {
  BOOST_OUTCOME_TRY(others, match(regions, tiles));
  std::vector<std::uint32_t> first;  // by region: its first cell in the whole
  std::size_t cells = 0;
  // By region and its border: which arc of the whole it is.
  std::vector<std::vector<cut::Arc>> arc_of(regions.size());
  for (std::size_t r = 0; r < regions.size(); ++r) {
    cut::CutKernel& kernel = regions[r].kernel;
    std::vector<cut::Decided> across;
    for (const std::uint32_t border : kernel.borders)
      across.push_back(regions[others[r][border].region].at_border[others[r][border].border]);
    cut::take_decided(kernel, across);
    first.push_back(static_cast<std::uint32_t>(cells));
    arc_of[r].assign(regions[r].names.size(), cut::no_arc);
    for (std::size_t i = 0; i < kernel.borders.size(); ++i)
      arc_of[r][kernel.borders[i]] = static_cast<cut::Arc>(4 * cells) + kernel.graph.borders[i].arc;
    cells += kernel.graph.cells();
    if (cells > cut::cells_max) return error(Errc::memory, "more cells are undecided than fit into one cut");
  }
  cut::CutGraph whole;
  whole.excess.reserve(cells);
  whole.capacity.reserve(4 * cells);
  whole.back.reserve(4 * cells);
  for (std::size_t r = 0; r < regions.size(); ++r) {
    cut::CutKernel& kernel = regions[r].kernel;
    cut::CutGraph& graph = kernel.graph;
    whole.excess.insert(whole.excess.end(), graph.excess.begin(), graph.excess.end());
    whole.capacity.insert(whole.capacity.end(), graph.capacity.begin(), graph.capacity.end());
    for (const cut::Arc back : graph.back) {
      if (back == cut::no_arc) {
        whole.back.push_back(back);
      } else if (cut::is_inner(back)) {
        whole.back.push_back(back + 4 * first[r]);
      } else {
        const Side& other = others[r][kernel.borders[back & ~cut::border_bit]];
        whole.back.push_back(arc_of[other.region][other.border]);
      }
    }
    graph = {};
    kernel.cells = {};
  }
  BOOST_OUTCOME_TRY(reached, solve(whole, prove));
  std::vector<cut::CellSet> out;
  for (std::size_t r = 0; r < regions.size(); ++r) {
    const std::size_t end = r + 1 < regions.size() ? first[r + 1] : cells;
    cut::CellSet& set = out.emplace_back(end - first[r]);
    for (std::uint32_t cell = first[r]; cell < end; ++cell)
      if (reached.contains(cell)) set.insert(cell - first[r]);
  }
  return out;
}

}  // namespace tessera::surface
