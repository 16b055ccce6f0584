// The mail of one tile: batches that wait to be processed, the latest in memory, the others on scratch.
#pragma once

#include <cstdint>
#include <vector>

#include "src/run/batch.h"
#include "src/run/tile_storage.h"

namespace tessera {

class Mail {
 public:
  // At most `points_max` points, and a batch, are held in memory.
  Mail(TileId tile, std::uint64_t points_max) : tile_(tile), points_max_(points_max) {}

  Status add(Batch batch, TileStorage& storage);
  // Everything that waits, the points on scratch first; nothing waits afterwards. Error corrupt when what was on
  // scratch is not what was put there.
  Result<std::vector<Batch>> take(TileStorage& storage);

  std::uint64_t batches() const { return batches_; }
  std::uint64_t points() const { return points_; }  // on scratch, too
  std::uint64_t memory() const { return held_points_ * sizeof(SharedPoint) + held_.capacity() * sizeof(Batch); }

 private:
  Status spill(TileStorage& storage);

  TileId tile_;
  std::uint64_t points_max_;
  std::vector<Batch> held_;
  std::uint64_t held_points_ = 0, batches_ = 0, points_ = 0;
};

}  // namespace tessera
