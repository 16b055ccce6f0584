// The shape of a region.
#pragma once

#include <functional>
#include <span>

#include "src/base/point.h"

namespace tessera {

// Tests whether a cell that meets the box around a region also meets the region. `cell` has dimension + 1 vertices, or
// the 3 vertices of a flat triangle in the plane, and is positively oriented. Without a function the region is the
// whole box.
using RegionShape = std::function<bool(std::span<const Point> cell)>;

}  // namespace tessera
