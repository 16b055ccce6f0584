// A tile's part of the cut: from weights to a graph, to what the tile decides alone, and to labels.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "src/base/big_vector.h"
#include "src/base/result.h"
#include "src/surface/cut/reduce.h"
#include "src/surface/records.h"
#include "src/surface/surface_tile.h"

namespace tessera::surface {

struct CutRule {
  // what is beyond hull facets that look down is inside; their normal is at most 60 degrees off straight down
  bool lower_inside = true;
  bool unknown_inside = true;  // of all minimum cuts the one with the fewest cells outside; else the one with the most
};

// Whether what is beyond this facet of the hull is inside.
bool is_inside_beyond(const SurfaceTile& tile, std::int32_t cell, std::size_t facet, const CutRule& rule);

// Passes to the callbacks what rays have left here of other tiles' arcs and cells, and forgets it.
void give_sums(SurfaceTile& tile, const std::function<void(TileId, const SumRecord&)>& sum,
               const std::function<void(TileId, const VoteRecord&)>& vote);
Status take_sum(SurfaceTile& tile, const SumRecord& sum);
Status take_vote(SurfaceTile& tile, const VoteRecord& vote);

// Passes to the callbacks the arcs of cells that are main elsewhere, across facets that are main here; and votes of the
// hull's facets for such cells. REQUIRES: all sums have been taken.
Status give_arcs(const SurfaceTile& tile, const Energy& energy, const CutRule& rule,
                 const std::function<void(TileId, const ArcRecord&)>& arc,
                 const std::function<void(TileId, const VoteRecord&)>& vote);

// An arc to a cell of another tile, by the name that both sides use.
struct BorderName {
  std::array<PointId, 3> facet;  // ascending
  TileId to;
};

// Some of the cells: those that are main in a tile, in its order, or those that several tiles have not decided.
struct CutRegion {
  cut::CutGraph graph;
  std::vector<BorderName> names;        // of all arcs to other regions, also of cells that are decided
  std::vector<cut::Decided> at_border;  // by name: what was decided of the cell here
  std::vector<std::uint32_t> borders;   // by border of the graph: its name
};
// Returns the region of a tile. `arcs`: from other tiles. REQUIRES: all votes have been taken.
Result<CutRegion> region_of(SurfaceTile& tile, const Energy& energy, const CutRule& rule,
                            std::span<const ArcRecord> arcs);

// What is left of a region when it has decided what it can.
struct ReducedRegion {
  cut::ReducedGraph kernel;  // its borders refer to the region's names
  std::vector<BorderName> names;
  std::vector<cut::Decided> at_border;
  cut::CellSet sources, open;  // of the region's cells: decided to be on the source's side; not decided
};
// Decides what the region can decide by itself. `prove`: error internal when the flow of a cut that decides does not
// prove it.
Result<ReducedRegion> kernel_of(CutRegion region, bool prove);

// Returns the same for a region that decides nothing by itself.
ReducedRegion all_of(CutRegion region);

// What several regions have left, as one region. Borders between these regions are inner arcs.
struct JoinedRegion {
  CutRegion region;
  std::vector<std::uint32_t> first;  // by region: its first cell
};
// Joins regions, and forgets their graphs. `region_of`: in which of these regions the cells of a tile are; nothing: in
// another region. Errors: corrupt when two regions do not name the same borders; memory.
Result<JoinedRegion> join(std::vector<ReducedRegion>& regions,
                          const std::function<std::optional<std::uint32_t>(TileId)>& region_of);

}  // namespace tessera::surface
