// What a region decides by itself, for good, and the graph of the cells that are left.
//
// If every arc out of the region led to the sink, the source set that is found could only be too small. If every arc
// into the region came from the source, it could only be too large. The smallest minimum cut of the whole lies between
// the two (docs/surfaces.md proves it by submodularity).
#pragma once

#include <cstdint>
#include <vector>

#include "src/surface/cut/cut_graph.h"

namespace tessera::cut {

enum class Decided : std::uint8_t { no, source, sink };

// Return graphs whose smallest source sets are the least and the most that the source's side can have in the region.
// REQUIRES: in the region no path leads from an excess to a deficit any more (SearchTrees::run()).
CutGraph with_borders_to_sink(CutGraph graph);
CutGraph with_borders_from_source(CutGraph graph);
// Returns what these two sets decide of each cell. In a region without borders both sets are equal.
std::vector<Decided> decided_by(const CellSet& least, const CellSet& most, std::uint32_t cells);
inline std::vector<Decided> decided_by(const CellSet& source, std::uint32_t cells) {
  return decided_by(source, source, cells);
}

// The region without the cells that are decided. Arcs from a decided source cell become excess; arcs to a decided sink
// cell become deficit.
struct ReducedGraph {
  CutGraph graph;
  std::vector<std::uint32_t> cells;    // by cell of the kernel: the cell of the region
  std::vector<std::uint32_t> borders;  // by border of the kernel: the border of the region
};
ReducedGraph kernel_of(const CutGraph& graph, const std::vector<Decided>& decided);

// Removes borders whose cell across has been decided. `across`: by border, what was decided; Decided::no for borders
// that stay. The borders that stay keep their order.
void take_decided(ReducedGraph& kernel, const std::vector<Decided>& across);

}  // namespace tessera::cut
