// Where the steps of a surface find tiles, and what earlier steps have kept of them.
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

// Thread-safe, but a tile may be used by one thread at a time.
class StepStore {
 public:
  virtual ~StepStore() = default;

  // Returns a tile as the result has it, without weights. Errors: of reading.
  virtual Result<std::unique_ptr<SurfaceTile>> take(TileId tile) = 0;
  // Gives a tile back. It may stay in memory for the next take().
  virtual Status give_back(std::unique_ptr<SurfaceTile> tile) = 0;

  // Keeps bytes of a tile; every node of the job can read them. They are written once, or again with the same content.
  virtual Status write(StepOutput what, TileId tile, std::span<const std::byte> bytes) = 0;
  // Error corrupt when the bytes are missing, or are not what was written.
  virtual Result<Bytes> read(StepOutput what, TileId tile) = 0;
  // Stores a tile of the surface. Returns bytes that describe it, for the end of the job.
  virtual Result<Bytes> keep_triangles(TileId tile, const StoredTile& triangles) = 0;
};

}  // namespace tessera::surface
