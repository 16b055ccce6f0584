// The order of the vertices of cells.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>

#include "src/base/image.h"
#include "src/geometry/mesh/tile_mesh.h"

namespace tessera {

// Orders vertices by source index, and the images of one point by offset. The order of two images stays the same when
// both are shifted. So the vertices of a cell have the same order in all copies of the cell, in all tiles: what is
// computed of them in this order has the same bits everywhere.
struct ImageOrder {
  PointId id;
  std::uint32_t rank = 0;  // of the offset
  friend auto operator<=>(const ImageOrder&, const ImageOrder&) = default;
};

inline ImageOrder image_order(const TileMesh& mesh, std::size_t vertex) {
  const std::uint32_t code = mesh.offsets.empty() ? 0 : mesh.offsets[vertex];
  return {mesh.ids[vertex], image::rank(image::offset(code))};
}

}  // namespace tessera
