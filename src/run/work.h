// What a tile is told to do next.
#pragma once

#include <cstdint>

namespace tessera {

enum class Work : std::uint8_t { begin, splay, sleep, settle, collect, drop, hand_over };

constexpr const char* name_of(Work work) {
  constexpr const char* names[] = {"begin", "splay", "sleep", "settle", "collect", "drop", "hand over"};
  return names[static_cast<int>(work)];
}

}  // namespace tessera
