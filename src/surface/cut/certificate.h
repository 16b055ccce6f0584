// Whether a flow proves a cut: what solvers and heuristics have done before does not matter then (docs/surfaces.md).
#pragma once

#include <string>

#include "src/surface/cut/cut_graph.h"

namespace tessera::cut {

// Empty when `after` is `before` with some flow moved inside of it, within the capacities, and this flow proves that
// `source` is the smallest minimum cut; else a sentence's end that says what does not hold. Arcs across borders carry
// nothing and do not count.
std::string why_no_proof(const CutGraph& before, const CutGraph& after, const CellSet& source);

}  // namespace tessera::cut
