// Hillshades, by GDAL's own code.
#pragma once

#include <cstdint>
#include <stop_token>
#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/result/terrain/dem.h"

namespace tessera::terrain {

// What `gdaldem hillshade` is told: with this light, and as with -compute_edges, pixels beside those without a height,
// too, by Horn's formula.
std::vector<std::string> hillshade_words(const Light& light);

// In place of the array's heights its hillshade, from 1 to 255; NaN where there is none. `res`: the width of a pixel.
// Errors: io without GDAL, or when it fails; interrupted.
Status shade(DemArray& array, double res, const Light& light, const std::stop_token& stop);

}  // namespace tessera::terrain
