// Decides exactly whether a cell and a box, both with their boundaries, have a point in common.
#pragma once

#include <span>

#include "src/base/point.h"

namespace tessera {

// `cell` has dimension + 1 vertices and is positively oriented; `box` is finite and may be flat. In 2D z is ignored.
// Cell and box are disjoint if and only if a line (a plane) separates them. Then one of these also separates them: a
// line or plane parallel to a facet of either, or in 3D a plane parallel to an edge of each. So exact predicates test
// all of these.
bool meets(std::span<const Point> cell, const Bounds& box);

}  // namespace tessera
