// The contour lines of a result, from its tiles to lines that wait on disk.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <stop_token>

#include "src/base/result.h"
#include "src/result/store/tile_store.h"
#include "src/result/terrain/contour_lines.h"
#include "src/result/terrain/contours.h"
#include "src/result/terrain/levels.h"

namespace tessera::terrain {

// Error usage for options that are wrong, and for a 3D result.
Status check_contours(const std::filesystem::path& out, const Manifest& manifest, const ContourOptions& options);

// Lines that were traced, and what they are of.
struct Traced {
  Manifest manifest;
  ContourLines lines;
  Levels levels;
  std::uint64_t left_out = 0;  // cells, for their edges
};

// Of the surface as it is, or with options.smooth of a smooth one. `folder`: where lines and samples wait. `progress`:
// is told the part that is done. Errors: of write_contours(), but those of the target.
Result<Traced> trace(const std::filesystem::path& out, const std::filesystem::path& folder,
                     const ContourOptions& options, const std::function<void(double)>& progress,
                     const std::stop_token& stop);

}  // namespace tessera::terrain
