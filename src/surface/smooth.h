// Takes noise out of a surface: each vertex goes halfway to the mean of its neighbours, then all go back a little
// farther than that, so that the surface does not shrink. After G. Taubin, A signal processing approach to fair surface
// design, SIGGRAPH 1995. Sums are in the order of ids, so that no tiling and no thread changes a bit.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>

#include "src/base/result.h"
#include "src/surface/triangle_store.h"

namespace tessera::surface {

struct SmoothOptions {
  unsigned rounds = 1;  // of both steps
  TileWork how;
  std::function<void(double)> progress = {};  // or null
};

// The triangles of `from`, with vertices moved, to `to`. Vertices where the surface ends stay. `scratch`: an empty
// folder.
Status smooth(const TileSource& from, TriangleStore& to, const std::filesystem::path& scratch,
              const SmoothOptions& options);

}  // namespace tessera::surface
