// What the Delaunay tiles of a job on one node have in common.
#pragma once

#include <cstdint>
#include <memory>
#include <stop_token>
#include <vector>

#include "src/base/point.h"
#include "src/delaunay/delaunay_store.h"
#include "src/exchange/tile_program.h"
#include "src/tiling/tile/tile_triangulation.h"

namespace tessera {

// Read-only while tiles work.
struct DelaunayStage final : TilePrograms {
  std::unique_ptr<TileProgram> program_of(TileId tile) const override;
  // Whether a tile of `points` points stores some of its final cells early.
  bool stores_early(std::uint64_t points) const {
    return kind == TileKind::cells && early_points > 0 && points >= early_points;
  }

  int dimension = 3;
  KernelKind kernel = KernelKind::flat;
  // Whether tiles hand out final cells and keep only the rest: that needs a tenth of the memory, and a tenth more work.
  bool reduce = false;
  // Whether tiles store cells. With points instead, final cells are counted and dropped as soon as they are known.
  TileKind kind = TileKind::cells;
  // Tiles of at least `early_points` points hand out final cells in any case. They store the early cells, a multiple of
  // `early_unit`, while other tiles are still triangulated. 0: no tile does. A tile's file depends on these two values,
  // not on when or by which process it is stored.
  std::uint64_t early_points = 0, early_unit = 1;
  // By tile. A tile with the empty box has no final cells, and announces nothing.
  std::shared_ptr<const std::vector<Box>> boxes;
  std::shared_ptr<const KnownFromStart> around;
  TileStorage* storage = nullptr;  // for what is kept beside the images
  DelaunayStore* store = nullptr;
  std::stop_token stop = {};  // once requested, long work soon throws Stopped
};

}  // namespace tessera
