// Between the vertices: how much of each makes a point.
#pragma once

#include <vector>

#include "src/base/result.h"
#include "src/result/query/dual.h"
#include "src/result/query/walker.h"

namespace tessera::query {

// A vertex, as a tile has it that is pinned, and its part.
struct Weight {
  const QueryTile* tile = nullptr;
  std::int32_t vertex = -1;
  long double weight = 0;
  PointId id() const { return tile->id_of(vertex); }
};

// Barycentric coordinates of q in its cell: not negative, 0 for the vertices opposite facets that it is on. They add up
// to 1.
std::vector<Weight> linear_weights(const Located& located, const Point& q);

// Sibson's natural neighbour coordinates (Sibson 1980): the part of q's Voronoi cell that each vertex would lose to q.
// The cells whose open circumsphere has q are found from the one that has it on, with exact predicates, so cospherical
// vertices need no care: what they add is 0. Volumes are of long doubles, and of 512 bits where weights are negative or
// do not give q back within 1e-10 of the shortest edge between its neighbours and it. Empty on vertices and facets of
// the hull.
Result<std::vector<Weight>> natural_weights(Walker& walker, const Located& located, const Point& q);

}  // namespace tessera::query
