// Where the steps of a surface find tiles, and what the steps before have left of them.
#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "src/base/big_vector.h"
#include "src/base/ids.h"
#include "src/base/result.h"
#include "src/result/store/tile_store.h"
#include "src/surface/step.h"
#include "src/surface/surface_tile.h"

namespace tessera::surface {

using Bytes = BigVector<std::byte>;

// For several threads at once, but a tile for one at a time.
class StepStore {
 public:
  virtual ~StepStore() = default;

  // As the result has it, without weights. Errors: of reading.
  virtual Result<std::unique_ptr<SurfaceTile>> take(TileId tile) = 0;
  // It may stay in memory for whoever takes it next.
  virtual Status give_back(std::unique_ptr<SurfaceTile> tile) = 0;

  // Every node of the job reads what one has written. It is written once, or the same again.
  virtual Status write(Kept what, TileId tile, std::span<const std::byte> bytes) = 0;
  // Error corrupt when it is not there, or not what was written.
  virtual Result<Bytes> read(Kept what, TileId tile) = 0;
  // A tile of the surface. The bytes say what is to be known of it in the end.
  virtual Result<Bytes> keep_triangles(TileId tile, const StoredTile& triangles) = 0;
};

}  // namespace tessera::surface
