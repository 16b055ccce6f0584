// Receives the tiles of a job as they are finished, in place of files.
#pragma once

#include <mutex>
#include <set>

#include "src/base/ids.h"
#include "src/base/result.h"
#include "src/result/store/tile_store.h"

namespace tessera {

class TileConsumer {
 public:
  TileConsumer() = default;
  virtual ~TileConsumer() = default;
  TileConsumer(const TileConsumer&) = delete;
  TileConsumer& operator=(const TileConsumer&) = delete;

  // Receives a tile with cells, neighbours and rows. Called by several threads, for different tiles. A job that finds
  // its scratch damaged makes tiles again. A tile that comes again is ignored, because it is the same tile.
  Status take(TileId tile, const StoredTile& cells);

 private:
  virtual Status use(const StoredTile& cells) = 0;

  std::mutex mutex_;
  std::set<TileId> taken_;
};

}  // namespace tessera
