#include "src/result/query/tile_cache.h"

#include "src/base/files/names.h"

namespace tessera::query {

Result<PinnedTile> TileCache::get(TileId tile, bool with_rows) {
  const auto index = source_.find(tile);
  if (!index)
    return error(Errc::corrupt, manifest_file(source_.folder()).string() + ": has no tile " + to_string(tile) +
                                    ", but other tiles say that it owns vertices");
  std::unique_lock lock(mutex_);
  for (;;) {
    Slot& slot = slots_[tile];
    slot.used = ++clock_;
    if (slot.tile && (slot.tile->has_rows() || !with_rows)) return slot.tile;
    if (!slot.loading) break;
    loaded_.wait(lock);
  }
  slots_[tile].loading = true;
  ++loads_;
  lock.unlock();
  auto loaded = QueryTile::load(source_, *index, with_rows);
  lock.lock();
  Slot& slot = slots_[tile];
  slot.loading = false;
  loaded_.notify_all();
  if (!loaded) return loaded.error();
  if (slot.tile) bytes_ -= slot.tile->bytes();
  slot.tile = loaded.value();
  bytes_ += slot.tile->bytes();
  evict();
  return loaded;
}

void TileCache::evict() {
  while (bytes_ > bytes_max_) {
    auto oldest = slots_.end();
    for (auto slot = slots_.begin(); slot != slots_.end(); ++slot) {
      const bool idle = slot->second.tile && !slot->second.loading && slot->second.tile.use_count() == 1;
      if (idle && (oldest == slots_.end() || slot->second.used < oldest->second.used)) oldest = slot;
    }
    if (oldest == slots_.end()) return;
    bytes_ -= oldest->second.tile->bytes();
    slots_.erase(oldest);
  }
}

std::uint64_t TileCache::loads() const {
  const std::lock_guard lock(mutex_);
  return loads_;
}

std::uint64_t TileCache::bytes() const {
  const std::lock_guard lock(mutex_);
  return bytes_;
}

}  // namespace tessera::query
