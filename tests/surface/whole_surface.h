// The surface of a whole cloud by other means than the product's: one tile, and a flow by another library.
#pragma once

#include <vector>

#include "src/base/point.h"
#include "src/surface/energy.h"
#include "src/surface/region.h"
#include "src/surface/sensors.h"
#include "tests/surface/triangles_of_result.h"

namespace tessera::surface {

// Of points whose ids are their numbers, ascending.
std::vector<IdTriangle> surface_of_whole(const std::vector<Point>& points, const SensorOptions& where,
                                         const Energy& energy, const CutRule& rule);

}  // namespace tessera::surface
