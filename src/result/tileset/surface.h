// A piece of a triangle surface in memory, which can be divided, joined and simplified.
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
  TileId tile;  // the tile that owns it
  std::uint16_t intensity = 0;
  std::uint8_t classification = 0;
};

// A surface has each vertex once, and only vertices of its triangles.
struct Surface {
  std::vector<SurfaceVertex> vertices;
  std::vector<std::uint32_t> corners;  // three a triangle, counterclockwise from above

  std::size_t triangles() const { return corners.size() / 3; }
  Bounds bounds() const;
};

// Divides the surface into up to four parts that lie side by side and have about equally many triangles. Each triangle
// is in exactly one part. `axes` is the number of axes along which parts are cut, 2 or 3.
std::vector<Surface> quarters(const Surface& surface, int axes);

// Joins surfaces. Vertices with the same id become one.
Surface join(std::span<const Surface* const> parts);

// Simplifies to about `triangles` triangles, with a subset of the vertices. The border is kept: edges that are passed
// more often one way than the other, and their ends. So surfaces that fit together still fit, whichever of them are
// simplified and however often. A surface with many border edges keeps more triangles.
Surface simplify(const Surface& surface, std::size_t triangles);

// The distance in height of the vertices of `fine` from `coarse`, which simplify() made of it: the root of the mean
// square, in units of the coordinates. Nearly upright edges can leave a vertex with no triangle of `coarse` above or
// below. For such a vertex the distance to a nearby corner is used, which is not less than that to the surface.
double height_error(const Surface& fine, const Surface& coarse);

// The same with distances in space.
double distance_error(const Surface& fine, const Surface& coarse);

}  // namespace tessera::tileset
