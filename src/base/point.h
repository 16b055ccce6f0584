// Points and boxes. Coordinates are in input units, never shifted or rounded: all tiles must see the same bits.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <compare>
#include <cstdint>
#include <limits>

#include "src/base/ids.h"

namespace tessera {

// In 2D, z is 0. Never -0: readers normalise, so equal coordinates are equal bits.
struct Point {
  double x = 0, y = 0, z = 0;
  friend auto operator<=>(const Point&, const Point&) = default;
  double operator[](int axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
  double& operator[](int axis) { return axis == 0 ? x : axis == 1 ? y : z; }
};

inline bool is_finite(const Point& p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); }

// Adding +0 turns -0 into +0 and changes nothing else.
inline Point without_negative_zero(const Point& p) { return {p.x + 0.0, p.y + 0.0, p.z + 0.0}; }

// A point that was routed: what the tile files of a run folder hold, byte for byte (32 bytes, little endian).
struct LocalPoint {
  Point at;
  PointId id;
  friend bool operator==(const LocalPoint&, const LocalPoint&) = default;
};
static_assert(sizeof(LocalPoint) == 32);

// What tiles tell each other: a point and the tile that owns it. Sent as raw bytes.
struct SharedPoint {
  Point at;
  PointId id;
  TileId tile;
  std::uint32_t told = 0;  // which of its owner's neighbours have been told of it, as far as the sender knows, as bits
  friend bool operator==(const SharedPoint&, const SharedPoint&) = default;
};
static_assert(sizeof(SharedPoint) == 40);

// A point that every tile knows from the start whose points come within `reach` of it.
struct Seed {
  SharedPoint point;
  double reach = 0;  // in input units; infinity: all tiles
  friend bool operator==(const Seed&, const Seed&) = default;
};

// Half-open: lo <= p < hi on each axis. Unbounded sides are -inf and +inf.
struct Box {
  Point lo{-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(),
           -std::numeric_limits<double>::infinity()};
  Point hi{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(),
           std::numeric_limits<double>::infinity()};
  bool contains(const Point& p) const {
    return lo.x <= p.x && p.x < hi.x && lo.y <= p.y && p.y < hi.y && lo.z <= p.z && p.z < hi.z;
  }
  friend bool operator==(const Box&, const Box&) = default;
};

// The closed bounding box of points seen so far; empty at first (lo = +inf, hi = -inf).
struct Bounds {
  Point lo{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(),
           std::numeric_limits<double>::infinity()};
  Point hi{-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(),
           -std::numeric_limits<double>::infinity()};
  bool empty() const { return lo.x > hi.x; }
  void add(const Point& p) {
    lo = {std::min(lo.x, p.x), std::min(lo.y, p.y), std::min(lo.z, p.z)};
    hi = {std::max(hi.x, p.x), std::max(hi.y, p.y), std::max(hi.z, p.z)};
  }
  void add(const Bounds& b) {
    if (b.empty()) return;
    add(b.lo);
    add(b.hi);
  }
  friend bool operator==(const Bounds&, const Bounds&) = default;
};

}  // namespace tessera
