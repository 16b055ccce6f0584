// The zones of a watershed, the saddles between them, and the hierarchy of voids that follows.
//
// Zones are flooded in the order of their saddles, as in Kruskal's algorithm for spanning trees. When zones join at a
// saddle, the deepest core of what joins stays, and each other core that was the deepest of its part has found its
// void: the zones that its part had before. That is the definition of ZOBOV, where water rises over a core until it
// would flow into a zone with a lower core. Saddles at the same vertex are one level, and join what they join together.
// Source: Neyrinck, ZOBOV: a parameter-free void-finding algorithm, MNRAS 386 (2008), section 2.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "src/base/point.h"
#include "src/result/measure/order_free_sum.h"
#include "src/result/voids/level.h"

namespace tessera::voids {

// Zones are numbered in the order of the source indices of their cores.
using ZoneNumber = std::uint32_t;
inline constexpr ZoneNumber no_zone = std::numeric_limits<ZoneNumber>::max();

struct Zone {
  Level core;
  Point place;  // of the core
  std::uint64_t points = 0;
  OrderFreeSum volume;
};

struct Saddle {
  ZoneNumber a = no_zone, b = no_zone;  // a < b
  Level level;
};

// The void of a zone. The void of a zone that is the deepest of all that it is connected with has all of these zones,
// and no saddle.
struct Void {
  std::optional<Level> saddle;  // over which it flows out
  ZoneNumber parent = no_zone;  // the zone with the deepest core of those that join at the saddle
  std::uint64_t zones = 1;      // of the void, its own included
  std::uint64_t points = 0;     // of all of them
  OrderFreeSum volume;
};

class ZoneGraph {
 public:
  // The zones, in any order. REQUIRES: fewer than 2^32 - 1; their cores differ.
  explicit ZoneGraph(std::vector<Zone> zones = {});
  std::vector<Zone>& zones() { return zones_; }
  const std::vector<Zone>& zones() const { return zones_; }
  // The zone with this core; no_zone when it is no core.
  ZoneNumber find(PointId core) const;

  // Adds saddles, in any order, as often as they come. Keeps those that matter: a spanning forest of the lowest. So the
  // memory is in proportion to the number of zones. Not thread-safe.
  void add(std::span<const Saddle> saddles);
  // The void of each zone.
  std::vector<Void> voids();

 private:
  void keep_forest();
  std::vector<Zone> zones_;
  std::vector<Saddle> saddles_;
  std::size_t kept_ = 0;
};

// The probability that a void of this density contrast arises in a Poisson process: fits of ZOBOV's author, exp(-5.12
// (r - 1) - 0.8 (r - 1)^2.8) in 3D (the paper's equation 1), exp(-2.6 (r - 1)) in 2D (zobovpostproc.py).
double void_probability(double contrast, int dimension);

}  // namespace tessera::voids
