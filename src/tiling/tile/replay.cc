// Sends again what may be lost, for this tile or for reborn tiles: docs/recovery.md.
#include <algorithm>

#include "src/tiling/tile/tile_triangulation.h"

namespace tessera {

void TileTriangulation::replay() {
  replay_if([](TileId) { return true; });
}

void TileTriangulation::replay_to(std::span<const TileId> reborn) {
  replay_if([&](TileId tile) { return std::binary_search(reborn.begin(), reborn.end(), tile); });
}

// Pairs that this tile relied on are sent to living tiles, too: the tile that claimed to have told them may have died
// before its message arrived. From now on these pairs count as sent by this tile, and so do the told bits that are
// left.
void TileTriangulation::replay_if(const std::function<bool(TileId)>& reborn) {
  const auto tell = [&](std::uint64_t pair) {
    updates_[TileId{static_cast<std::uint32_t>(pair)}].push_back(static_cast<Vertex>(pair >> 32));
    ++counts_.sent;
  };
  for (const std::uint64_t pair : sent_.keys()) {
    const TileId tile{static_cast<std::uint32_t>(pair)};
    if (owners_[pair >> 32] != tile && reborn(tile)) tell(pair);
  }
  for (const std::uint64_t pair : relied_) {
    if (!reborn(TileId{static_cast<std::uint32_t>(pair)})) tell(pair);
  }
  relied_.clear();
  for (RefusedRelied& r : refused_relied_) {
    if (!r.by_told_bit && !reborn(r.tile)) continue;
    refused_updates_[r.tile].push_back(r.point);
    r.by_told_bit = 0;
    ++counts_.sent;
  }
  forget_told_bits();
}

void TileTriangulation::forget_told_bits() {
  std::fill(told_.begin(), told_.end(), 0);
  for (const std::uint64_t pair : sent_.keys()) {
    const auto v = static_cast<Vertex>(pair >> 32);
    told_[v] |= options_.around->bit(owners_[v], TileId{static_cast<std::uint32_t>(pair)});
  }
}

}  // namespace tessera
