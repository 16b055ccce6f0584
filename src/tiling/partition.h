// Tells which tile owns a point. Half-open boxes cover space disjointly (for tests there is a hash of the coordinates,
// too).
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "src/base/image.h"
#include "src/base/point.h"
#include "src/base/result.h"
#include "src/base/tile_map.h"
#include "src/tiling/split_tree.h"

namespace tessera {

enum class PartitionKind : std::uint8_t { kdtree, grid, octree, random };

const char* name_of(PartitionKind kind);
Result<PartitionKind> parse_partition_kind(const std::string& name);

// A partition of space into tiles. Properties:
//  (1) tile_of is a function of the coordinates alone, and boxes()[tile_of(p).value].contains(p).
//  (2) Boxes are disjoint and cover space, so outer boxes are unbounded. With `random` every box is all of space.
//  (3) There are at most tiles_max tiles; larger requests are cut down to it.
class Partition {
 public:
  static constexpr std::uint32_t tiles_max = 1'000'000;  // file names have six digits

  // Makes tiles that should hold at most `limit` points. `sample`: points that are spread like the cloud; `total`: the
  // number of points in the cloud.
  // kdtree: median splits along the longest side of the sample's bounds. grid: equal boxes over `bounds`.
  // octree: splits a cubic root box while more than `limit` (scaled to the sample) points are inside.
  // If the sample is not the whole cloud, kdtree makes somewhat more than total/limit tiles, so that sampling errors
  // seldom overfill a tile. A tile can still exceed the limit: see split().
  static Partition build(PartitionKind kind, int dimension, std::span<const Point> sample, const Bounds& bounds,
                         std::uint64_t total, std::uint64_t limit);
  // The same with a number of tiles instead of a limit. kdtree and random make exactly `tiles`. grid and octree make
  // the nearest number that is possible and not smaller (grid: near-cubic boxes, at most a quarter more).
  static Partition build_tiles(PartitionKind kind, int dimension, std::span<const Point> sample, const Bounds& bounds,
                               std::uint32_t tiles);

  // Makes one tile that is all of space.
  Partition() : boxes_(1) {}

  PartitionKind kind() const { return kind_; }
  int dimension() const { return dimension_; }
  std::uint32_t tiles() const { return static_cast<std::uint32_t>(boxes_.size()); }
  const std::vector<Box>& boxes() const { return boxes_; }
  const std::vector<SplitNode>& splits() const { return nodes_; }  // empty with one tile, and with `random`
  // The period of the space that is cut into tiles. The outer boxes are unbounded all the same.
  const Period& period() const { return period_; }
  void set_period(const Period& period) { period_ = period; }
  TileId tile_of(const Point& p) const {
    return kind_ == PartitionKind::random ? hashed_tile(p, tiles()) : leaf_of(nodes_, p);
  }

  // Splits a tile in two at the exact median of `points`, which are all in the tile, along the axis that halves them
  // best (the longest axis of those within a tenth of the best). The left half keeps the number; the right half gets
  // number tiles().
  // Returns false, and changes nothing, when all points are equal, the kind is random, or there are tiles_max tiles.
  // REQUIRES: tile_of(p) is `tile` for all points.
  bool split(TileId tile, std::vector<Point> points);

  // Returns {"kind": "kdtree", "dimension": 3, "tiles": 2, "splits": [[axis, coordinate, below, above], ...]}, where
  // `below` and `above` are the row of another split, or -1-tile. Boxes follow from the splits. Coordinates come back
  // exactly. With a period there is {"period": [x, y, z]}, too.
  std::string to_json() const;
  static Result<Partition> from_json(const std::string& text);  // checks everything, as the text comes from a file

 private:
  Partition(PartitionKind kind, int dimension, std::vector<SplitNode> nodes, std::uint32_t tiles);
  static TileId hashed_tile(const Point& p, std::uint32_t tiles);

  PartitionKind kind_ = PartitionKind::kdtree;
  int dimension_ = 3;
  std::vector<SplitNode> nodes_;  // empty with one tile, and with `random`
  std::vector<Box> boxes_;        // by tile
  Period period_;
};

// Returns the layout that displays of progress use.
TileLayout layout_of(const Partition& partition, const Bounds& bounds);

}  // namespace tessera
