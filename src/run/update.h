// Points from one tile to another, on their way.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "src/base/point.h"
#include "src/quiescence/counters.h"

namespace tessera {

struct Update {
  Peer from, to;
  std::uint64_t epoch = 0;  // of the table by which it was sent
  std::uint32_t hops = 0;   // of the chain of updates that caused one another and ends with this one
  std::vector<SharedPoint> points;
};

// An update is about a megabyte at most, so that whatever carries it stays responsive.
inline constexpr std::size_t update_points_max = 25'000;

inline std::string to_string(const Update& update) {
  return "Update(" + std::to_string(update.from.tile.value) + " -> " + std::to_string(update.to.tile.value) + ", " +
         std::to_string(update.points.size()) + " points, hop " + std::to_string(update.hops) + ")";
}

}  // namespace tessera
