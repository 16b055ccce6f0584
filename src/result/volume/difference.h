// The difference of two surfaces as a raster.
#pragma once

#include <filesystem>
#include <optional>
#include <stop_token>

#include "src/base/result.h"
#include "src/result/terrain/dem.h"
#include "src/result/volume/volumes.h"

namespace tessera {

// Writes A - B at the centres of pixels of width `res`, as write_dem() samples surfaces: above 0 where A lies above B,
// which is cut. The raster covers the common bounds of A and B, and has no value where one of them has none. Where
// polygons of a base overlap, the first is B. options.within does not limit the raster. Writes under a temporary name,
// beside scratch files twice as large as the raster of doubles. Errors: those of volumes(), and of write_dem().
Result<Dem> write_difference(const std::filesystem::path& a, const std::optional<std::filesystem::path>& b,
                             const std::filesystem::path& target, double res, bool overwrite,
                             const VolumeOptions& options, std::stop_token stop);

}  // namespace tessera
