// How the triangles of a surface hang together where more than two of them meet at an edge, or more than one fan of
// them at a vertex: two triangles belong together at an edge if nothing but outside lies between them.
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

// A corner of a triangle that belongs to another fan than the vertex's first: its copy of the vertex, 1 for the second
// fan. A vertex's fans are ordered by their least triangles.
struct SplitCorner {
  TriangleName triangle;
  PointId vertex;
  std::uint32_t copy = 0;
};

// Where such a copy stands: a little off the vertex, towards the mean of the fan's other vertices, so that programs
// that tell vertices by their coordinates do not take it for the vertex.
struct CopyPlace {
  PointId vertex;
  std::uint32_t copy = 0;
  Point at;
};

// Two triangles that belong together at an edge that has more of them, or one that is alone there, and twice here.
// `edge`: ascending.
struct PairAtEdge {
  std::array<PointId, 2> edge;
  TriangleName first, second;  // first <= second
  Point middle;                // of the edge, moved a little towards the triangles' other vertices
};

// What a tile knows of its own vertices, and of edges whose vertex with the lesser id is its own.
struct Splits {
  std::vector<SplitCorner> corners;
  std::vector<CopyPlace> places;
  std::vector<PairAtEdge> pairs;
};

// `facets`: of the surface, all that have a vertex of the tile's own. Error corrupt when cells contradict each other.
Result<Splits> splits_of(const SurfaceTile& tile, std::span<const Label> labels, const CutRule& rule,
                         const Boundary& boundary, std::span<const SurfaceFacet> facets);

}  // namespace tessera::surface
