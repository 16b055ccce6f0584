#include "src/exchange/tile_storage.h"

#include <string>

namespace tessera {

Status remove_beginnings(TileStorage& storage, TileId tile) {
  for (const ScratchKind what : {ScratchKind::state, ScratchKind::finals}) {
    BOOST_OUTCOME_TRYV(storage.remove(tile, what));
  }
  return storage.forget_handed(tile);
}

Error damaged(TileId tile, const char* what) {
  return error(Errc::corrupt, "tile " + std::to_string(tile.value) + ": its " + what + " on disk is damaged");
}

Result<bool> can_be_built_alone(TileStorage& storage, TileId tile, bool many_nodes) {
  BOOST_OUTCOME_TRY(settled, storage.has(tile, ScratchKind::settled));
  if (settled || many_nodes) return settled;
  return storage.has(tile, ScratchKind::state);  // the tile was asleep when all was quiet
}

}  // namespace tessera
