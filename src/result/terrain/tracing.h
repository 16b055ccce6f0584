// Traces the contour lines of a result, from its tiles to lines that are kept on disk.
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

// Error usage for wrong options and for a 3D result.
Status check_contours(const std::filesystem::path& out, const Manifest& manifest, const ContourOptions& options);

// Lines that were traced, and their source.
struct Traced {
  Manifest manifest;
  ContourLines lines;
  Levels levels;
  std::uint64_t left_out = 0;  // cells left out because of their edges
};

// Traces the lines of the surface, or with options.smooth of a smooth one. Lines and samples are kept in `folder`.
// `progress` is called with the fraction that is done. Errors: those of write_contours(), except those of the target.
Result<Traced> trace(const std::filesystem::path& out, const std::filesystem::path& folder,
                     const ContourOptions& options, const std::function<void(double)>& progress,
                     const std::stop_token& stop);

}  // namespace tessera::terrain
