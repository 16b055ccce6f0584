// What a region decides by itself, for ever, and the graph of the cells that are left.
//
// If every arc out of the region led to the sink, the source set that is found could only be too small; if every arc
// into it came from the source, it could only be too large: the smallest minimum cut of the whole lies between
// (docs/surfaces.md has the proof, by submodularity).
#pragma once

#include <cstdint>
#include <vector>

#include "src/surface/cut/cut_graph.h"

namespace tessera::cut {

enum class Decided : std::uint8_t { no, source, sink };

// Of a region in which no way leads from an excess to a deficit (SearchTrees::run()) any more: graphs whose smallest
// source sets are the least and the most that the source's side can have in the region.
CutGraph with_borders_to_sink(CutGraph graph);
CutGraph with_borders_from_source(CutGraph graph);
// Of each cell, by these sets; in a region without borders both are one.
std::vector<Decided> decided_by(const CellSet& least, const CellSet& most, std::uint32_t cells);
inline std::vector<Decided> decided_by(const CellSet& source, std::uint32_t cells) {
  return decided_by(source, source, cells);
}

// The region without the cells that are decided: arcs from a decided source cell are excess, arcs to a decided sink
// cell deficit.
struct CutKernel {
  CutGraph graph;
  std::vector<std::uint32_t> cells;    // by cell of the kernel: of the region
  std::vector<std::uint32_t> borders;  // by border of the kernel: of the region
};
CutKernel kernel_of(const CutGraph& graph, const std::vector<Decided>& decided);

// The cells across these borders are decided, and so these arcs are no more: of each border what it is, Decided::no for
// those that stay. The borders that stay keep their order.
void take_decided(CutKernel& kernel, const std::vector<Decided>& across);

}  // namespace tessera::cut
