// Counts of cells.
#pragma once

#include <cstdint>

namespace tessera::voronoi {

struct CellCounts {
  std::uint64_t unbounded = 0;  // in 2D of the written ones; in 3D without a box of all, which are not written
  std::uint64_t outside = 0;    // not written, because they do not meet the region
  std::uint64_t shapeless = 0;  // 2D: written without a shape; 3D: not written
  std::uint64_t thin = 0;       // that lost parts, or their whole shape, which are thinner than doubles resolve
  void add(const CellCounts& other) {
    unbounded += other.unbounded;
    outside += other.outside;
    shapeless += other.shapeless;
    thin += other.thin;
  }
};

}  // namespace tessera::voronoi
