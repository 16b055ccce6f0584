// Tiles on nodes that are lost, without threads, files or actors: one seeded, arbitrary order of everything that can
// happen. Tables reach each tile at a time of its own; mail overtakes them; what the dead have sent is lost or comes
// late; and a node that is taken for dead may live on for a while and go on sending.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "src/base/point.h"
#include "src/geometry/kernel/kernel.h"
#include "src/geometry/mesh/tile_mesh.h"
#include "tests/tile/setting.h"

namespace tessera::testing {

struct RecoveryOptions {
  int dimension = 3;
  std::uint64_t seed = 0;
  KernelKind kernel = KernelKind::flat;
  Announced announced = Announced::spanning;
  bool reduce = false;
  bool announce = true;
  std::uint64_t mail_bytes_max = ~std::uint64_t{0};
  std::uint32_t losses = 1;    // of one or several tiles at once
  std::uint32_t patience = 8;  // about so many steps between two of them
  bool random_seeds = true;
  bool sleep = true;
  bool prompt = false;  // most tables arrive before any mail does
  bool images = false;  // the reborn may begin from what the dead have left on scratch
  bool settle = false;  // at the end all are built from points and foreign vertices
};

struct Recovered {
  std::string wrong;  // what must not be
  std::vector<TileMesh> meshes;
  std::uint32_t losses = 0;
};
Recovered recover(const std::vector<LocalPoint>& points, const Assignment& assignment, const RecoveryOptions& options);

}  // namespace tessera::testing
