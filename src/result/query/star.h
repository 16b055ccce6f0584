// The star of a vertex, with its Voronoi cell.
#pragma once

#include <optional>

#include "src/result/query/stored_triangulation.h"

namespace tessera::query {

// As StoredTriangulation::star().
Result<Star> star_of(const OpenedResult& result, PointId id, std::optional<TileId> owner, const AskOptions& options);

// As StoredTriangulation::neighbours().
Result<Neighbours> neighbours_of(const OpenedResult& result, PointId id, std::optional<TileId> owner,
                                 const AskOptions& options);

}  // namespace tessera::query
