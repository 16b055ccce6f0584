// Takes noise out of a surface. Each vertex moves halfway to the mean of its neighbours; then all move back a little
// farther, so that the surface does not shrink. After G. Taubin, A signal processing approach to fair surface design,
// SIGGRAPH 1995. Sums are in the order of ids, so no tiling and no thread changes a bit.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>

#include "src/base/result.h"
#include "src/surface/triangle_store.h"

namespace tessera::surface {

struct SmoothOptions {
  unsigned rounds = 1;  // each round does both steps
  TileWork how;
  std::function<void(double)> progress = {};  // called with the fraction that is done; or null
};

// Writes the triangles of `from`, with moved vertices, to `to`. Vertices at the ends of the surface stay. `scratch`: an
// empty folder.
Status smooth(const TileSource& from, TriangleStore& to, const std::filesystem::path& scratch,
              const SmoothOptions& options);

}  // namespace tessera::surface
