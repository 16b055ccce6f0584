// Remembers what a share has told its coordinator, so that it says each thing once until that becomes true anew. A
// plain object.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace tessera {

// What is true of all tiles of the share: they have begun the stage; have nothing to do; have settled; have come to the
// end.
enum class ShareEvent : std::uint8_t { begun, idle, settled, collected };

class ToldOnce {
 public:
  // Returns whether the event is to be told now. It counts as told from then on.
  bool mark_told(ShareEvent event) { return !std::exchange(said_[static_cast<std::size_t>(event)], true); }
  void forget(ShareEvent event) { said_[static_cast<std::size_t>(event)] = false; }
  void forget_all() { said_ = {}; }

 private:
  std::array<bool, 4> said_{};
};

}  // namespace tessera
