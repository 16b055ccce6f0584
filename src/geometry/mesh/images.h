// Cells and faces of a tile of a periodic result: their vertices are images (src/base/image.h), and a tile may have
// several copies of a cell or face, which differ by a shift.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "src/base/image.h"
#include "src/geometry/mesh/image_order.h"
#include "src/geometry/mesh/tile_mesh.h"

namespace tessera {

// The offset of a vertex.
inline PeriodOffset offset_of(const TileMesh& mesh, std::int32_t vertex) {
  return mesh.offsets.empty() ? PeriodOffset{} : image::offset(mesh.offsets[static_cast<std::size_t>(vertex)]);
}

// The lowest id among the owners of the vertices.
inline TileId main_tile(const TileMesh& mesh, std::span<const std::int32_t> vertices) {
  TileId least = mesh.owners[static_cast<std::size_t>(vertices[0])];
  for (const std::int32_t v : vertices.subspan(1)) least = std::min(least, mesh.owners[static_cast<std::size_t>(v)]);
  return least;
}

// Whether a cell or face is the main one of all its copies in all tiles: it is in its main tile, and of the copies
// there it is the one in which the least offset of the tile's own points is 0 (docs/periodic-design.md). REQUIRES: the
// tile `self` has the cell, or all cells around the face.
inline bool is_main(const TileMesh& mesh, std::span<const std::int32_t> vertices, TileId self) {
  if (main_tile(mesh, vertices) != self) return false;
  if (mesh.offsets.empty()) return true;
  bool some = false;
  PeriodOffset least;
  for (const std::int32_t v : vertices) {
    if (mesh.owners[static_cast<std::size_t>(v)] != self) continue;
    const PeriodOffset o = offset_of(mesh, v);
    if (!some || o < least) least = o;
    some = true;
  }
  return least == PeriodOffset{};
}

// The offset by which a cell or face must be shifted back, so that its least vertex (image_order.h) has the offset 0.
// All copies are the same then, whatever the tiles are.
inline PeriodOffset base_offset(const TileMesh& mesh, std::span<const std::int32_t> vertices) {
  if (mesh.offsets.empty()) return {};
  return offset_of(mesh, *std::min_element(vertices.begin(), vertices.end(), [&](std::int32_t a, std::int32_t b) {
                     return image_order(mesh, static_cast<std::size_t>(a)) <
                            image_order(mesh, static_cast<std::size_t>(b));
                   }));
}

// The image that a vertex is after a shift back by `base`.
inline PointId image_of(const TileMesh& mesh, std::int32_t vertex, const PeriodOffset& base) {
  const PointId id = mesh.ids[static_cast<std::size_t>(vertex)];
  return mesh.offsets.empty() ? id : image_of(id, offset_of(mesh, vertex) - base);
}

}  // namespace tessera
