// Turns labels of cells into the triangles of a surface.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "src/base/result.h"
#include "src/result/store/tile_store.h"
#include "src/surface/region.h"
#include "src/surface/surface_tile.h"

namespace tessera::surface {

enum class Label : std::uint8_t { inside, outside, unknown };

// What a surface leaves out of the boundary between inside and outside.
struct Boundary {
  bool below = true;                // the inside ends at the hull's facets that look down; else it goes on there
  std::optional<double> trim = {};  // leaves out triangles with a longer edge; then the surface has holes
};

// Passes to the callback the labels of cells that are main here, for the other tiles that hold them.
void give_labels(const SurfaceTile& tile, std::span<const Label> labels,
                 const std::function<void(TileId, const LabelRecord&)>& label);

// A triangle of the surface: the facet of a cell opposite one of its corners. `outwards`: the cell is inside. Else the
// cell is outside, and what is beyond the facet, which is on the hull, is inside.
struct SurfaceFacet {
  std::int32_t cell = 0;
  std::uint8_t corner = 0;
  bool outwards = true;
};
// Returns all triangles that have a vertex of the tile's own. `labels`: of all cells. Error corrupt when a label that
// is needed is unknown.
Result<std::vector<SurfaceFacet>> facets_of(const SurfaceTile& tile, std::span<const Label> labels, const CutRule& rule,
                                            const Boundary& boundary);
// Returns the vertices, counterclockwise as seen from outside.
std::array<std::int32_t, 3> vertices_of(const SurfaceTile& tile, const SurfaceFacet& facet);
// The name of a triangle in all tiles: the source indices of its vertices, ascending.
using TriangleName = std::array<PointId, 3>;
TriangleName name_of(const SurfaceTile& tile, const SurfaceFacet& facet);

// Returns the facets as triangles of a 2D result with the heights as first attribute "z".
StoredTile triangles_of(const SurfaceTile& tile, std::span<const SurfaceFacet> facets);

// Puts triangles, given by vertex numbers, into the mesh in the order of a result, each with its least vertex first.
// Triangles that are main in another tile than `self` become ghosts, as cells do.
void put_triangles(std::vector<std::array<std::int32_t, 3>> triangles, TileId self, TileMesh& mesh);

}  // namespace tessera::surface
