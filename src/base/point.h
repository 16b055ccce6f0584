// Points and boxes. Coordinates are in the units of the input and are never shifted or rounded, because all tiles must
// see the same bits.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <compare>
#include <cstdint>
#include <limits>

#include "src/base/ids.h"

namespace tessera {

// A point. In 2D z is 0. A coordinate is never -0: readers normalise, so that equal coordinates are equal bits.
struct Point {
  double x = 0, y = 0, z = 0;
  friend auto operator<=>(const Point&, const Point&) = default;
  double operator[](int axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
  double& operator[](int axis) { return axis == 0 ? x : axis == 1 ? y : z; }
};

inline bool is_finite(const Point& p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); }

// Adding +0 turns -0 into +0 and changes no other value.
inline Point without_negative_zero(const Point& p) { return {p.x + 0.0, p.y + 0.0, p.z + 0.0}; }

// A point that was routed. The files of a run folder contain these 32 bytes, little endian.
struct LocalPoint {
  Point at;
  PointId id;
  friend bool operator==(const LocalPoint&, const LocalPoint&) = default;
};
static_assert(sizeof(LocalPoint) == 32);

// What tiles tell each other: a point and the tile that owns it. It is sent as raw bytes.
struct SharedPoint {
  Point at;
  PointId id;
  TileId tile;
  // The told bits: bit k says that the owner's k-th neighbour has been told of the point, as far as the sender knows.
  std::uint32_t told = 0;
  friend bool operator==(const SharedPoint&, const SharedPoint&) = default;
};
static_assert(sizeof(SharedPoint) == 40);

// A point that tiles know from the start. A tile has the seed when the tile's points come within `reach` of it.
struct Seed {
  SharedPoint point;
  double reach = 0;  // in units of the input; infinity: all tiles have the seed
  friend bool operator==(const Seed&, const Seed&) = default;
};

// A half-open box: lo <= p < hi on each axis. An unbounded side is -inf or +inf.
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

// The closed bounding box of the points that were added. It begins empty (lo = +inf, hi = -inf).
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
