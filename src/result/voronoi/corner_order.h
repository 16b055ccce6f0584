// Corners in the plane, in lexicographic order.
#pragma once

#include "src/base/point.h"

namespace tessera::voronoi {

inline bool same(const Point& a, const Point& b) { return a.x == b.x && a.y == b.y; }
inline bool before(const Point& a, const Point& b) { return a.x != b.x ? a.x < b.x : a.y < b.y; }

}  // namespace tessera::voronoi
