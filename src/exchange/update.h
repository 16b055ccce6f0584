// A message from one tile to another, on its way. What it says only the tiles know.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "src/base/big_vector.h"
#include "src/exchange/counters.h"

namespace tessera {

struct Update {
  TileIncarnation from, to;
  Epoch epoch;             // of the table by which it was sent
  std::uint32_t hops = 0;  // of the chain of updates that caused one another and ends with this one
  BigVector<std::byte> message;
};

// Whatever carries a message stays responsive: none is longer.
inline constexpr std::size_t message_bytes_max = 1'000'000;

inline std::string to_string(const Update& update) {
  return "Update(" + std::to_string(update.from.tile.value) + " -> " + std::to_string(update.to.tile.value) + ", " +
         std::to_string(update.message.size()) + " bytes, hop " + std::to_string(update.hops) + ")";
}

}  // namespace tessera
