// What a part has said to its coordinator, so that it says each thing once until something makes it true anew. Pure.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace tessera {

// All tiles of the part: have begun the stage; have nothing to do; have settled; have come to their end.
enum class ShareEvent : std::uint8_t { begun, idle, settled, collected };

class ToldOnce {
 public:
  // Whether it is to be said now: from then on it has been.
  bool first(ShareEvent word) { return !std::exchange(said_[static_cast<std::size_t>(word)], true); }
  void forget(ShareEvent word) { said_[static_cast<std::size_t>(word)] = false; }
  void forget_all() { said_ = {}; }

 private:
  std::array<bool, 4> said_{};
};

}  // namespace tessera
