// Points from one tile to another, on their way.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "src/base/point.h"
#include "src/quiescence/counters.h"

namespace tessera {

struct Batch {
  Peer from, to;
  std::uint32_t hops = 0;  // of the chain of batches that caused one another and ends with this one
  std::vector<SharedPoint> points;
};

// A batch is about a megabyte at most, so that whatever carries it stays responsive.
inline constexpr std::size_t batch_points_max = 25'000;

inline std::string to_string(const Batch& batch) {
  return "Batch(" + std::to_string(batch.from.tile.value) + " -> " + std::to_string(batch.to.tile.value) + ", " +
         std::to_string(batch.points.size()) + " points, hop " + std::to_string(batch.hops) + ")";
}

}  // namespace tessera
