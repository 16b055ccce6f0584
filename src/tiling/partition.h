// Which tile owns a point: a disjoint cover of space by half-open boxes (or, for tests, a hash of the coordinates).
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/base/tile_map.h"
#include "src/tiling/split_tree.h"

namespace tessera {

enum class PartitionKind : std::uint8_t { kdtree, grid, octree, random };

const char* name_of(PartitionKind kind);
Result<PartitionKind> parse_partition_kind(const std::string& name);

// Properties:
//  (1) tile_of is a function of the coordinates alone, and boxes()[tile_of(p).value].contains(p).
//  (2) Boxes are disjoint and cover space, so outer ones are unbounded; with `random` every box is all of space.
//  (3) At most tiles_max tiles: larger requests are cut down to it.
class Partition {
 public:
  static constexpr std::uint32_t tiles_max = 1'000'000;  // file names have six digits

  // `sample`: points spread like the cloud; `total`: points in the cloud; `limit`: points a tile should hold at most.
  // kdtree: median splits along the longest side of the sample's bounds. grid: equal boxes over `bounds`.
  // octree: splits a cubic root box while more than `limit` (scaled to the sample) points are inside.
  // kdtree makes a few tiles more than total/limit when the sample is not the cloud, so that its error seldom overfills
  // one. A tile can still exceed the limit: see split().
  static Partition build(PartitionKind kind, int dimension, std::span<const Point> sample, const Bounds& bounds,
                         std::uint64_t total, std::uint64_t limit);
  // The same with a number of tiles instead: exactly `tiles` for kdtree and random; for grid and octree the nearest
  // number not below it that the kind can make (grid: near-cubic boxes, at most a quarter more).
  static Partition build_tiles(PartitionKind kind, int dimension, std::span<const Point> sample, const Bounds& bounds,
                               std::uint32_t tiles);

  // One tile that is all of space.
  Partition() : boxes_(1) {}

  PartitionKind kind() const { return kind_; }
  int dimension() const { return dimension_; }
  std::uint32_t tiles() const { return static_cast<std::uint32_t>(boxes_.size()); }
  const std::vector<Box>& boxes() const { return boxes_; }
  const std::vector<SplitNode>& splits() const { return nodes_; }  // none with one tile, and with `random`
  TileId tile_of(const Point& p) const {
    return kind_ == PartitionKind::random ? hashed_tile(p, tiles()) : leaf_of(nodes_, p);
  }

  // Splits a tile in two at the exact median of `points` (all of that tile) along the axis that halves them best (the
  // longest of those within a tenth of the best); the left half keeps the number, the right half gets number tiles().
  // False when all points are equal, kind is random, or there are tiles_max tiles. REQUIRES: tile_of is `tile` for all.
  bool split(TileId tile, std::vector<Point> points);

  // {"kind": "kdtree", "dimension": 3, "tiles": 2, "splits": [[axis, coordinate, below, above], ...]} where `below` and
  // `above` are a row of splits, or -1-tile. Boxes follow from the splits; coordinates round-trip exactly.
  std::string to_json() const;
  static Result<Partition> from_json(const std::string& text);  // checks everything: comes from a file

 private:
  Partition(PartitionKind kind, int dimension, std::vector<SplitNode> nodes, std::uint32_t tiles);
  static TileId hashed_tile(const Point& p, std::uint32_t tiles);

  PartitionKind kind_ = PartitionKind::kdtree;
  int dimension_ = 3;
  std::vector<SplitNode> nodes_;  // empty with one tile, and with `random`
  std::vector<Box> boxes_;        // by tile
};

// For those who watch.
TileLayout layout_of(const Partition& partition, const Bounds& bounds);

}  // namespace tessera
