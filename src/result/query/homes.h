// Finds the tile in which the search for a point begins.
#pragma once

#include <filesystem>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/result/store/tile_store.h"
#include "src/tiling/partition.h"

namespace tessera::query {

class Homes {
 public:
  // Error corrupt when the partition is damaged or has no tile with points.
  static Result<Homes> of(const std::filesystem::path& out, const Manifest& manifest);
  // A tile with points: the tile whose box contains q, or a nearby one when that tile is empty.
  TileId operator()(const Point& q) const { return stand_in_[partition_.tile_of(q).value]; }

 private:
  Partition partition_;
  std::vector<TileId> stand_in_;  // by tile: the tile itself when it has points
};

}  // namespace tessera::query
