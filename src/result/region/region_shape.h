// The shape of a region.
#pragma once

#include <functional>
#include <span>

#include "src/base/point.h"

namespace tessera {

// Whether a cell that meets the box around a region meets the region itself: `cell` has dimension + 1 vertices, or 3 of
// its place in the plane, and is positively oriented. Null: all do, the region is the box.
using RegionShape = std::function<bool(std::span<const Point> cell)>;

}  // namespace tessera
