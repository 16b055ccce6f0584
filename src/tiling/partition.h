// Which tile owns a point: a disjoint cover of space by half-open boxes (or, for tests, a hash of the coordinates).
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"

namespace tessera {

enum class PartitionKind : std::uint8_t { kdtree, grid, octree, random };

const char* name_of(PartitionKind kind);
Result<PartitionKind> parse_partition_kind(const std::string& name);

// Properties:
//  (1) tile_of is a function of the coordinates alone, and boxes()[tile_of(p).value].contains(p).
//  (2) Boxes are disjoint and cover space, so outer ones are unbounded; with `random` every box is all of space.
class Partition {
 public:
  // `sample`: points spread like the cloud; `total`: points in the cloud; `limit`: points a tile should hold at most.
  // kdtree: median splits along the longest side of the sample's bounds. grid: equal boxes over `bounds`.
  // octree: splits a cubic root box while more than `limit` (scaled to the sample) points are inside.
  static Partition build(PartitionKind kind, int dimension, std::span<const Point> sample, const Bounds& bounds,
                         std::uint64_t total, std::uint64_t limit);
  // The same with a number of tiles instead: exactly `tiles` for kdtree and random; for grid and octree the nearest
  // number not below it that the kind can make.
  static Partition build_tiles(PartitionKind kind, int dimension, std::span<const Point> sample, const Bounds& bounds,
                               std::uint32_t tiles);

  PartitionKind kind() const;
  int dimension() const;
  std::uint32_t tiles() const;
  const std::vector<Box>& boxes() const;
  TileId tile_of(const Point& p) const;

  // Splits a tile in two at the exact median of `points` (all of that tile) along the axis that halves them best; the
  // left half keeps the number, the right half gets number tiles(). False when all points are equal, or kind is random.
  bool split(TileId tile, std::vector<Point> points);

  std::string to_json() const;
  static Result<Partition> from_json(const std::string& text);  // checks everything: comes from a file
};

}  // namespace tessera
