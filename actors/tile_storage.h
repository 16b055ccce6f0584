// Where a tile's bytes live while it runs: on disk in production, in memory in the harness.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/store/tile_store.h"
#include "src/tile/tile_mesh.h"
#include "src/tiling/routed_run.h"

namespace tessera {

enum class Scratch : std::uint8_t {
  state,   // a sleeping tile
  finals,  // its final cells, until it is stored
  mail,    // PointBatch records that came while it was not in memory; appended to
};

// Calls for different tiles may come from different threads at once; those for one tile come one after the other.
class TileStorage {
 public:
  virtual ~TileStorage() = default;
  virtual Result<LoadedTile> load_points(TileId tile) = 0;
  virtual Status put(TileId tile, Scratch what, std::span<const std::byte> bytes, bool append) = 0;
  // What was put, and forgets it; empty if nothing was.
  virtual Result<std::vector<std::byte>> take(TileId tile, Scratch what) = 0;
  // Keeps the result, and then tells `done`, from any thread. May return before.
  using Stored = std::function<void(Result<TileEntry>)>;
  virtual void store(TileId tile, TileMesh mesh, Stored done) = 0;
};

}  // namespace tessera
