#include "src/run/tile_storage.h"

namespace tessera {

Status remove_beginnings(TileStorage& storage, TileId tile) {
  for (const ScratchKind what : {ScratchKind::state, ScratchKind::finals, ScratchKind::settled}) {
    BOOST_OUTCOME_TRYV(storage.remove(tile, what));
  }
  return success();
}

bool can_be_built_alone(TileStorage& storage, TileId tile) {
  const auto settled = storage.read(tile, ScratchKind::settled);
  if (!settled) return false;
  if (!settled.value().empty()) return settled.value().size() == 1;
  // It slept when all was quiet: its image is its last state. If it had been awake, its image might be an older one.
  const auto image = storage.read(tile, ScratchKind::state);
  const auto finals = storage.read(tile, ScratchKind::finals);  // none when it was not reduced
  return image && image.value().size() == 1 && finals && finals.value().size() <= 1;
}

}  // namespace tessera
