// Finds the least radius for which an alpha shape is one piece with all points.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <stop_token>

#include "src/base/result.h"
#include "src/result/tile_source.h"

namespace tessera::alpha {

struct RadiusSearch {
  std::filesystem::path scratch;  // for unnamed files
  std::uint64_t memory_bytes = 0;
  unsigned threads = 1;
  std::function<void(double)> progress = {};
  std::stop_token stop = {};
};

// The least double R for which each vertex is a vertex of a cell in the shape, and all cells in the shape hang together
// by facets. CGAL's find_optimal_alpha(1) searches the same, up to rounding, but by bisection. The number of pieces is
// not monotone, so bisection may end at a larger radius. Memory holds what is in tiles that are worked on, and 64 bytes
// for each cell that tiles share. Errors: bad_input when no double is large enough; those of reading; io; interrupted.
Result<double> optimal_radius(const TileSource& source, const RadiusSearch& search);

}  // namespace tessera::alpha
