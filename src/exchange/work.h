// The kinds of work for which a tile gets a permit.
#pragma once

#include <cstdint>

namespace tessera {

enum class Work : std::uint8_t { begin, step, sleep, settle, finish, drop, hand_over };

constexpr const char* name_of(Work work) {
  constexpr const char* names[] = {"begin", "step", "sleep", "settle", "finish", "drop", "hand over"};
  return names[static_cast<int>(work)];
}

}  // namespace tessera
