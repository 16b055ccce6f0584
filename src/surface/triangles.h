// From labels to the triangles of a surface.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "src/base/result.h"
#include "src/store/tile_store.h"
#include "src/surface/region.h"
#include "src/surface/surface_tile.h"

namespace tessera::surface {

enum class Label : std::uint8_t { inside, outside, unknown };

// What a surface leaves out of the boundary between inside and outside.
struct Boundary {
  bool below = true;  // where the inside ends at the hull's facets that look down; else the inside goes on there
  std::optional<double> trim = {};  // triangles with a longer edge: then the surface has holes
};

// Labels of cells that are main here, for the other tiles that hold them.
void give_labels(const SurfaceTile& tile, std::span<const Label> labels,
                 const std::function<void(TileId, const LabelRecord&)>& label);

// All triangles with a vertex of the tile's own, counterclockwise from outside, the least vertex first; those that are
// main in another tile are ghosts, as cells are. In 2D as a result has it, with the heights as first attribute "z".
// `labels`: of all cells. Error corrupt when one is unknown.
Result<StoredTile> triangles_of(const SurfaceTile& tile, std::span<const Label> labels, const CutRule& rule,
                                const Boundary& boundary);

}  // namespace tessera::surface
