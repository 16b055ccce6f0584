// From a 3D result to the triangles of its surface, which whoever wants them reads as a 2D result with heights.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>

#include "src/base/result.h"
#include "src/store/digest.h"
#include "src/surface/passes.h"
#include "src/surface/surface.h"

namespace tessera::surface {

struct Built {
  std::filesystem::path triangles;  // the folder
  Digest digest;
  std::uint64_t split = 0;  // vertices that were added to make it manifold
  std::string sensors;      // a sentence
  std::unique_ptr<Passes> passes;
};

// `scratch`: an empty folder, in which the triangles are, too. `prove`: each cut is proved by its flow
// (src/cut/certificate.h); error internal when one is not. Errors: usage for results that have no surface; those of
// reading. `progress`: or null.
Result<Built> build(const TileSource& source, const SurfaceOptions& options, const std::filesystem::path& scratch,
                    bool prove, const std::function<void(double)>& progress, const std::stop_token& stop);

}  // namespace tessera::surface
