// Tiles of a periodic cloud exchanging stars, in one seeded, arbitrary order of delivery.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "src/geometry/kernel/kernel.h"
#include "src/geometry/mesh/tile_mesh.h"
#include "src/geometry/reference/periodic_reference.h"
#include "src/tiling/tile/tile_triangulation.h"

namespace tessera::testing {

struct PeriodicOptions {
  std::uint64_t seed = 0;
  std::string how = "random";  // see assign()
  std::uint32_t tiles = 1;
  KernelKind kernel = KernelKind::flat;
  bool announce = true;
  bool reduce = false;   // hand out final cells first
  bool counted = false;  // keep nothing of cells, and make them again from what the tile leaves
  bool sleep = false;    // save and load tiles between deliveries
  bool reborn = false;   // one tile begins again and again
  bool random_seeds = true;
};

// Returns each tile's mesh at quiescence.
std::vector<TileMesh> periodic_splay(const PeriodicCloud& cloud, const PeriodicOptions& options);

}  // namespace tessera::testing
