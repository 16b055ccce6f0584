// A message from one tile to another, with its address. Only the tiles' programs know what the message means.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "src/base/big_vector.h"
#include "src/exchange/counters.h"

namespace tessera {

struct Update {
  TileIncarnation from, to;
  Epoch epoch;             // of the routing table by which it was sent
  std::uint32_t hops = 0;  // length of the chain of updates, each caused by the one before, that ends with this one
  BigVector<std::byte> message;
};

// No message is longer, so that the actors and connections that carry messages stay responsive.
inline constexpr std::size_t message_bytes_max = 1'000'000;

inline std::string to_string(const Update& update) {
  return "Update(" + std::to_string(update.from.tile.value) + " -> " + std::to_string(update.to.tile.value) + ", " +
         std::to_string(update.message.size()) + " bytes, hop " + std::to_string(update.hops) + ")";
}

}  // namespace tessera
