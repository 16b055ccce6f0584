#include "src/result/store/tile_taker.h"

namespace tessera {

Status TileConsumer::take(TileId tile, const StoredTile& cells) {
  {
    const std::lock_guard lock(mutex_);
    if (!taken_.insert(tile).second) return success();
  }
  return use(cells);
}

}  // namespace tessera
