// Tiles of a periodic cloud exchanging stars, in one seeded, arbitrary order of delivery; and the right answer.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "src/base/image.h"
#include "src/base/point.h"
#include "src/geometry/kernel/kernel.h"
#include "src/geometry/mesh/tile_mesh.h"
#include "src/tiling/tile/tile_triangulation.h"

namespace tessera::testing {

// Distinct points between 0 and the period.
struct PeriodicCloud {
  int dimension = 3;
  Period period;
  std::vector<LocalPoint> points;
};

// A cell up to shifts by periods: sorted vertices, of which the first has the offset 0. Padded in 2D.
using PeriodicCell = std::array<std::pair<PointId, PeriodOffset>, 4>;

// The cells of the cloud, sorted, from one triangulation of `copies` copies along each axis that has a period: odd.
// Empty when the points do not span space.
std::vector<PeriodicCell> periodic_delaunay(const PeriodicCloud& cloud, int copies);
// The main cells of all meshes, sorted. A cell that is main in two meshes is listed twice.
std::vector<PeriodicCell> periodic_main_cells(std::span<const TileMesh> meshes);

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
