// Interpolation between vertices: the weight of each vertex at a point.
#pragma once

#include <vector>

#include "src/base/result.h"
#include "src/result/query/dual.h"
#include "src/result/query/walker.h"

namespace tessera::query {

// A vertex of a pinned tile, and its weight.
struct Weight {
  const QueryTile* tile = nullptr;
  std::int32_t vertex = -1;
  long double weight = 0;
  PointId id() const { return tile->id_of(vertex); }
};

// The barycentric coordinates of q in its cell. They are not negative, 0 for vertices opposite facets on which q lies,
// and add up to 1.
std::vector<Weight> linear_weights(const Located& located, const Point& q);

// Sibson's natural neighbour coordinates (Sibson 1980): the part of q's Voronoi cell that q would take from each
// vertex. The cells whose open circumsphere contains q are found with exact predicates, from the cell that contains q.
// Cospherical vertices need no special care, because they contribute 0. Volumes use long doubles, and 512 bits when
// weights are negative or do not give q back within 1e-10 of the shortest edge between q and its neighbours. Returns no
// weights on vertices and on facets of the hull.
Result<std::vector<Weight>> natural_weights(Walker& walker, const Located& located, const Point& q);

}  // namespace tessera::query
