// Many points at once: by tile, along a curve, by several threads.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <stop_token>

#include "src/result/query/homes.h"
#include "src/result/query/walker.h"

namespace tessera::query {

struct Batch {
  std::span<const Point> points;  // finite, in 2D with z = 0
  unsigned threads = 1;
  bool with_rows = false;
  std::stop_token stop = {};
};

// Is told where points[i] is. Called by several threads, for different points; what it finds by the walker is pinned
// until it returns.
using VisitLocated = std::function<Status(Walker& walker, std::size_t i, const Located& located)>;

// Locates all points and tells `visit` of each, in any order: those of a tile together, along a Hilbert curve, so that
// with a small cache a tile is read but once, and one answer is near the next. Errors: of reading; of `visit`;
// interrupted.
Status locate_all(TileCache& cache, const Manifest& manifest, const Homes& homes, const Batch& batch,
                  const VisitLocated& visit);

}  // namespace tessera::query
