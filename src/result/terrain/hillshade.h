// Hillshades, by GDAL's own code.
#pragma once

#include <cstdint>
#include <stop_token>
#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/result/terrain/dem.h"

namespace tessera::terrain {

// The words for `gdaldem hillshade` with this light: as with -compute_edges, also for pixels beside those without a
// height, by Horn's formula.
std::vector<std::string> hillshade_words(const Light& light);

// Replaces the array's heights by their hillshade, from 1 to 255; NaN where there is no height. `res` is the width of a
// pixel. Errors: io without GDAL, or when it fails; interrupted.
Status shade(DemArray& array, double res, const Light& light, const std::stop_token& stop);

}  // namespace tessera::terrain
