// Finds the neighbours of a tile's cells for results that were stored without them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <stop_token>

#include "src/base/result.h"
#include "src/geometry/mesh/tile_mesh.h"

namespace tessera {

// Fills mesh.neighbors: across each facet, the cell of this file. If there is none, -1 when the facet has an own vertex
// (this tile would have the other cell), and -2 otherwise (unknown). Needs 8 bytes a facet. Errors: not_delaunay when
// three cells share a facet, with the name of `file`; interrupted.
Status match_facets(TileMesh& mesh, const std::filesystem::path& file, const std::stop_token& stop = {});

}  // namespace tessera
