// A piece of a surface of triangles in memory: cut in parts, joined again, made coarser.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "src/base/point.h"

namespace tessera::tileset {

struct SurfaceVertex {
  Point at;
  PointId id;
  TileId tile;  // that owns it
  std::uint16_t intensity = 0;
  std::uint8_t classification = 0;
};

// Each vertex once, and only those that a triangle has.
struct Surface {
  std::vector<SurfaceVertex> vertices;
  std::vector<std::uint32_t> corners;  // three a triangle, counter-clockwise from above

  std::size_t triangles() const { return corners.size() / 3; }
  Bounds bounds() const;
};

// Up to four parts with about equally many triangles, one beside the other: each triangle is in exactly one. `axes`: by
// how many of them parts are cut, 2 or 3.
std::vector<Surface> quarters(const Surface& surface, int axes);

// Vertices with the same id become one.
Surface join(std::span<const Surface* const> parts);

// With about `triangles` triangles, and a subset of the vertices. The border stays as it is: edges that are passed more
// often one way than the other, and their ends. So surfaces that fit together still do, whichever of them are made
// coarser, and however often. With many such edges more triangles stay than are asked for.
Surface simplify(const Surface& surface, std::size_t triangles);

// How far the vertices of `fine` are from `coarse`, made from it by simplify(), in height: the root of the mean square,
// in units of the coordinates. Where no triangle of `coarse` is above or below a vertex, which edges nearly upright can
// lead to, the distance to a corner nearby counts, which is not less than that to the surface.
double height_error(const Surface& fine, const Surface& coarse);

// The same with distances in space.
double distance_error(const Surface& fine, const Surface& coarse);

}  // namespace tessera::tileset
