// The tiles that a share gives up before they have begun, because another node waits for work. A tile that was given up
// may still write to the scratch that its next incarnation on this node would use. So the share answers when all such
// tiles have left. A plain object.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "src/base/ids.h"

namespace tessera {

class TileReleases {
 public:
  // The share is asked to give up tiles. It owes one answer each time.
  void ask() { ++asked_; }
  // A tile is told to leave.
  void give_up(TileId tile) {
    given_up_.push_back(tile);
    ++leaving_;
  }
  // A tile has left.
  void leave() { --leaving_; }
  bool all_have_left() const { return leaving_ == 0; }
  // Returns the next answer that is owed, or nothing while tiles are still leaving or when none is owed. The first
  // answer has all tiles that were given up.
  std::optional<std::vector<TileId>> answer() {
    if (leaving_ > 0 || asked_ == 0) return std::nullopt;
    --asked_;
    return std::exchange(given_up_, {});
  }
  // Another coordinator has taken over, which owes nothing to what the one before was asked for. Tiles may still be
  // leaving.
  void forget_asked() {
    asked_ = 0;
    given_up_.clear();
  }

 private:
  std::uint32_t leaving_ = 0;     // tiles that were given up and are still there
  std::uint32_t asked_ = 0;       // number of answers that are owed
  std::vector<TileId> given_up_;  // tiles of which the coordinator was not told
};

}  // namespace tessera
