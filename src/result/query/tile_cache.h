// Keeps tiles of a result in memory, as many as a budget allows. The least recently used tiles are dropped first.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <utility>

#include "src/base/result.h"
#include "src/result/query/query_tile.h"
#include "src/result/tile_source.h"

namespace tessera::query {

using PinnedTile = std::shared_ptr<const QueryTile>;

// Thread-safe. A tile is pinned while a pointer to it exists: its memory counts, but is not freed. So the memory in use
// can exceed the budget by what all threads together have pinned.
class TileCache {
 public:
  TileCache(TileSource source, std::uint64_t bytes_max) : source_(std::move(source)), bytes_max_(bytes_max) {}

  // Returns the tile from memory or reads it. One thread reads, and other threads that want the tile wait. Errors:
  // those of QueryTile::load(); corrupt when the manifest has no such tile.
  Result<PinnedTile> get(TileId tile, bool with_rows);

  std::uint64_t loads() const;  // tiles read so far
  std::uint64_t bytes() const;  // held

 private:
  struct Slot {
    PinnedTile tile;
    bool loading = false;
    std::uint64_t used = 0;  // the higher, the later
  };
  void evict();  // REQUIRES: the lock is held

  TileSource source_;
  std::uint64_t bytes_max_;
  mutable std::mutex mutex_;
  std::condition_variable loaded_;
  std::map<TileId, Slot> slots_;
  std::uint64_t bytes_ = 0, clock_ = 0, loads_ = 0;
};

}  // namespace tessera::query
