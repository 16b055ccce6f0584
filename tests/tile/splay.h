// Tiles exchanging stars without threads, files or messages: one seeded, arbitrary order of delivery.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "src/base/point.h"
#include "src/geometry/mesh/tile_mesh.h"
#include "src/tiling/tile/tile_triangulation.h"
#include "tests/tile/setting.h"

namespace tessera::testing {

struct SplayOptions {
  int dimension = 3;
  std::uint64_t seed = 0;
  Announced announced = Announced::spanning;
  bool reduce = false;           // hand out final cells first
  bool counted = false;          // nothing is kept of cells: meshes are rebuilt, and must be what was counted
  std::uint64_t early_unit = 0;  // and as many units of them as there are are not given back
  bool announce = true;
  bool sleep = false;  // save and load tiles between deliveries
  ExchangeRule rule = ExchangeRule::introduce;
  bool single_points = false;  // deliver one point at a time
  KernelKind kernel = KernelKind::cgal;
};

// `tile_of[i]` owns points[i]; `boxes` by tile, all of space when empty (then no cell is final). Returns each tile's
// mesh at quiescence.
std::vector<TileMesh> splay(const std::vector<LocalPoint>& points, const std::vector<std::uint32_t>& tile_of,
                            const std::vector<Box>& boxes, const SplayOptions& options);

// A mesh's own arrays agree with each other: neighbours are mutual, ghosts and orientation right. "" or what is wrong.
std::string inconsistency(const TileMesh& mesh, TileId self);

}  // namespace tessera::testing
