// Checks whether a flow proves a cut. Then it does not matter how the flow was found (docs/surfaces.md).
#pragma once

#include <string>

#include "src/surface/cut/cut_graph.h"

namespace tessera::cut {

// Returns an empty string when `after` is `before` with some flow moved inside the region, within the capacities, and
// this flow proves that `source` is the source set of the smallest minimum cut. Else returns what does not hold, as the
// end of a sentence. Arcs across borders carry nothing and do not count.
std::string why_no_proof(const CutGraph& before, const CutGraph& after, const CellSet& source);

}  // namespace tessera::cut
