// Finds which triangles of a surface belong together, where an edge has more than two of them or a vertex has more than
// one fan of them. Two triangles belong together at an edge if only outside lies between them.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "src/base/result.h"
#include "src/surface/surface_tile.h"
#include "src/surface/triangles.h"

namespace tessera::surface {

// A corner of a triangle that belongs to another fan than the vertex's first. `copy`: the number of the fan, and of the
// vertex's copy; 1 is the second fan. A vertex's fans are ordered by their least triangles.
struct SplitCorner {
  TriangleName triangle;
  PointId vertex;
  std::uint32_t copy = 0;
};

// Where a copy of a vertex stands: a little off the vertex, towards the mean of the fan's other vertices. So programs
// that compare vertices by coordinates do not confuse the two.
struct CopyPlace {
  PointId vertex;
  std::uint32_t copy = 0;
  Point at;
};

// Two triangles that belong together at an edge with more triangles; or one triangle that is alone there, given twice.
// `edge`: ascending.
struct PairAtEdge {
  std::array<PointId, 2> edge;
  TriangleName first, second;  // first <= second
  Point middle;                // of the edge, moved a little towards the triangles' other vertices
};

// The splits at a tile's own vertices, and at edges whose vertex with the lesser id is its own.
struct Splits {
  std::vector<SplitCorner> corners;
  std::vector<CopyPlace> places;
  std::vector<PairAtEdge> pairs;
};

// `facets`: all of the surface that have a vertex of the tile's own. Error corrupt when cells contradict each other.
Result<Splits> splits_of(const SurfaceTile& tile, std::span<const Label> labels, const CutRule& rule,
                         const Boundary& boundary, std::span<const SurfaceFacet> facets);

}  // namespace tessera::surface
