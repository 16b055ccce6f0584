// The mail of one tile: updates that wait to be processed. The latest are in memory, the others on scratch. Not
// thread-safe.
#pragma once

#include <cstdint>
#include <vector>

#include "src/exchange/tile_storage.h"
#include "src/exchange/update.h"

namespace tessera {

class Inbox {
 public:
  // Holds at most `bytes_max` bytes of messages in memory, and the update that was added last.
  Inbox(TileId tile, std::uint64_t bytes_max) : tile_(tile), bytes_max_(bytes_max) {}

  Status add(Update update, TileStorage& storage);
  // Returns all updates that wait, those on scratch first. Nothing waits afterwards. Error corrupt when what is on
  // scratch is not what was put there.
  Result<std::vector<Update>> take(TileStorage& storage);
  // Forgets all updates, those on scratch, too.
  Status clear(TileStorage& storage);

  std::uint64_t updates() const { return updates_; }
  std::uint64_t bytes() const { return bytes_; }  // of messages, those on scratch included
  std::uint64_t memory() const { return held_bytes_ + held_.capacity() * sizeof(Update); }

 private:
  Status spill(TileStorage& storage);

  TileId tile_;
  std::uint64_t bytes_max_;
  std::vector<Update> held_;
  std::uint64_t held_bytes_ = 0, updates_ = 0, bytes_ = 0;
};

}  // namespace tessera
