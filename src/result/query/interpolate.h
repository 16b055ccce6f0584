// Values between vertices.
#pragma once

#include <span>
#include <vector>

#include "src/result/query/stored_triangulation.h"

namespace tessera::query {

// As StoredTriangulation::interpolate().
Result<std::vector<Interpolated>> interpolated(const OpenedResult& result, std::span<const Point> points,
                                               const InterpolateOptions& what, const AskOptions& options);

}  // namespace tessera::query
