// The mail of one tile: updates that wait to be processed, the latest in memory, the others on scratch.
#pragma once

#include <cstdint>
#include <vector>

#include "src/exchange/tile_storage.h"
#include "src/exchange/update.h"

namespace tessera {

class Mail {
 public:
  // At most `bytes_max` bytes of messages, and an update, are held in memory.
  Mail(TileId tile, std::uint64_t bytes_max) : tile_(tile), bytes_max_(bytes_max) {}

  Status add(Update update, TileStorage& storage);
  // Everything that waits, what is on scratch first; nothing waits afterwards. Error corrupt when what was on
  // scratch is not what was put there.
  Result<std::vector<Update>> take(TileStorage& storage);
  // Forgets all, on scratch, too.
  Status clear(TileStorage& storage);

  std::uint64_t updates() const { return updates_; }
  std::uint64_t bytes() const { return bytes_; }  // of messages; on scratch, too
  std::uint64_t memory() const { return held_bytes_ + held_.capacity() * sizeof(Update); }

 private:
  Status spill(TileStorage& storage);

  TileId tile_;
  std::uint64_t bytes_max_;
  std::vector<Update> held_;
  std::uint64_t held_bytes_ = 0, updates_ = 0, bytes_ = 0;
};

}  // namespace tessera
