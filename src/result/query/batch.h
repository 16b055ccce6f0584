// Locates many points at once: by tile, along a curve, on several threads.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <stop_token>

#include "src/result/query/homes.h"
#include "src/result/query/walker.h"

namespace tessera::query {

struct Batch {
  std::span<const Point> points;  // finite; in 2D with z = 0; in the box of a periodic result
  Period period = {};             // of the result
  unsigned threads = 1;
  bool with_rows = false;
  std::stop_token stop = {};
};

// Called with the location of points[i], by several threads for different points. Tiles that the walker finds are
// pinned until the call returns.
using VisitLocated = std::function<Status(Walker& walker, std::size_t i, const Located& located)>;

// Locates all points, and calls `visit` for each, in any order. Points of a tile are located together, along a Hilbert
// curve: so even with a small cache a tile is read only once, and each answer is near the one before. Errors: those of
// reading and of `visit`; interrupted.
Status locate_all(TileCache& cache, const Manifest& manifest, const Homes& homes, const Batch& batch,
                  const VisitLocated& visit);

}  // namespace tessera::query
