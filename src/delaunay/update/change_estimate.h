// What a change would cost, estimated without its exchange.
#pragma once

#include <cstdint>
#include <set>

#include "src/delaunay/update/update_plan.h"
#include "src/result/tile_source.h"
#include "src/tiling/partition.h"

namespace tessera {

// The tiles of new points and of removed points have fresh points, nearly always; the tiles beside them may have some.
std::set<TileId> tiles_that_begin(const UpdatePlan& plan);

struct ChangeEstimate {
  std::uint64_t begun = 0;         // tiles with new or removed points
  std::uint64_t begun_points = 0;  // old points of these
  // Of these tiles and of all that touch them. Others are seldom woken.
  std::uint64_t awake = 0, points = 0, bytes = 0;
};
// Reads no tile.
ChangeEstimate estimate_change(const TileSource& source, const Partition& partition, const UpdatePlan& plan);

}  // namespace tessera
