// Neighbours of a tile's cells for results that were stored without them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <stop_token>

#include "src/base/result.h"
#include "src/geometry/mesh/tile_mesh.h"

namespace tessera {

// Fills mesh.neighbors from the cells: the cell of this file across each facet; without one, -1 when the facet has an
// own vertex (this tile would hold the other cell), -2 otherwise (nobody knows). Error not_delaunay when three cells
// share a facet, in a sentence that names `file`; interrupted. 8 bytes a facet.
Status match_facets(TileMesh& mesh, const std::filesystem::path& file, const std::stop_token& stop = {});

}  // namespace tessera
