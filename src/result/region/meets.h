// Whether a cell has a point in common with a box, both with their boundaries: decided exactly.
#pragma once

#include <span>

#include "src/base/point.h"

namespace tessera {

// `cell`: dimension + 1 vertices, positively oriented; `box`: finite, perhaps flat. In 2D z does not count. They have
// no point in common if and only if a line (a plane) separates them, and then one does that is parallel to a facet of
// either, or in 3D to an edge of each: for all of these it is asked on which side the vertices are, by exact
// predicates.
bool meets(std::span<const Point> cell, const Bounds& box);

}  // namespace tessera
