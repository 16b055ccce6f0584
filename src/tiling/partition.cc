#include "src/tiling/partition.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace tessera {
namespace {

constexpr std::array<const char*, 4> kind_names{"kdtree", "grid", "octree", "random"};

// Returns how many kd tiles keep the fullest tile below the limit. A sample consists of runs of points that are
// neighbours in their file. So a tile with s sample points knows its border only as well as from s/64 independent
// points. Its size is off by (s/64)^-1/2, and an error of twice that is rare. A sample that is the whole cloud has no
// error.
std::uint32_t tiles_for_limit(std::size_t sample, std::uint64_t total, std::uint64_t limit) {
  const double exact = std::ceil(static_cast<double>(total) / static_cast<double>(limit));
  double margin = 1;
  if (sample < total && total > limit) {
    const double sample_per_tile = std::max(1.0, static_cast<double>(sample) / exact);
    margin = std::min(1.5, 1 + 2 / std::sqrt(sample_per_tile / 64));
  }
  return static_cast<std::uint32_t>(std::clamp(std::ceil(exact * margin), 1.0, double{Partition::tiles_max}));
}

std::uint32_t leaves_of(const std::vector<SplitNode>& nodes) { return static_cast<std::uint32_t>(nodes.size()) + 1; }

}  // namespace

const char* name_of(PartitionKind kind) { return kind_names[static_cast<std::size_t>(kind)]; }

Result<PartitionKind> parse_partition_kind(const std::string& name) {
  for (std::size_t i = 0; i < kind_names.size(); ++i) {
    if (name == kind_names[i]) return static_cast<PartitionKind>(i);
  }
  return error(Errc::usage, "partition \"" + name + "\" is not one of kdtree, grid, octree and random");
}

Partition::Partition(PartitionKind kind, int dimension, std::vector<SplitNode> nodes, std::uint32_t tiles)
    : kind_(kind), dimension_(dimension), nodes_(std::move(nodes)), boxes_(boxes_of(nodes_, tiles)) {}

Partition Partition::build(PartitionKind kind, int dimension, std::span<const Point> sample, const Bounds& bounds,
                           std::uint64_t total, std::uint64_t limit) {
  limit = std::max<std::uint64_t>(limit, 1);
  if (kind == PartitionKind::octree) {
    const double fraction =
        total == 0 ? 1 : std::min(1.0, static_cast<double>(sample.size()) / static_cast<double>(total));
    const auto sample_limit = static_cast<std::size_t>(std::max(1.0, static_cast<double>(limit) * fraction));
    auto nodes = build_octree(dimension, {sample.begin(), sample.end()}, bounds, sample_limit, tiles_max);
    const std::uint32_t leaves = leaves_of(nodes);
    return {kind, dimension, std::move(nodes), leaves};
  }
  // Only median splits profit from a margin: boxes of a grid overflow where points are dense, not by chance.
  const std::size_t known = kind == PartitionKind::kdtree ? sample.size() : total;
  return build_tiles(kind, dimension, sample, bounds, tiles_for_limit(known, total, limit));
}

Partition Partition::build_tiles(PartitionKind kind, int dimension, std::span<const Point> sample, const Bounds& bounds,
                                 std::uint32_t tiles) {
  tiles = std::clamp(tiles, 1u, tiles_max);
  // These kinds may make more tiles than they are asked for.
  if (kind == PartitionKind::grid) tiles = std::min(tiles, tiles_max / 5 * 4);
  if (kind == PartitionKind::octree) tiles = std::min(tiles, tiles_max - 7);
  std::vector<SplitNode> nodes;
  switch (kind) {
    case PartitionKind::kdtree:
      nodes = build_kd_tree(dimension, {sample.begin(), sample.end()}, tiles);
      break;
    case PartitionKind::grid:
      nodes = build_grid(dimension, bounds, tiles);
      break;
    case PartitionKind::octree:
      nodes = build_octree_tiles(dimension, {sample.begin(), sample.end()}, bounds, tiles);
      break;
    case PartitionKind::random:
      return {kind, dimension, {}, tiles};
  }
  const std::uint32_t leaves = leaves_of(nodes);
  return {kind, dimension, std::move(nodes), leaves};
}

TileId Partition::hashed_tile(const Point& p, std::uint32_t tiles) {
  const std::uint64_t hash = XXH3_64bits(&p, sizeof p) >> 32;
  return TileId{static_cast<std::uint32_t>(hash * tiles >> 32)};
}

bool Partition::split(TileId tile, std::vector<Point> points) {
  if (kind_ == PartitionKind::random || tiles() >= tiles_max || points.empty()) return false;
  Bounds bounds;
  for (const Point& p : points) bounds.add(p);
  struct Candidate {
    MedianSplit split;
    std::size_t smaller = 0;
    double length = 0;
  };
  std::array<Candidate, 3> candidates;
  std::size_t most = 0;
  for (int a = 0; a < dimension_; ++a) {
    if (bounds.lo[a] == bounds.hi[a]) continue;
    const MedianSplit split = median_split(points, a, points.size() / 2);
    candidates[a] = {split, std::min(split.below, points.size() - split.below), bounds.hi[a] - bounds.lo[a]};
    most = std::max(most, candidates[a].smaller);
  }
  if (most == 0) return false;
  int axis = -1;
  for (int a = 0; a < dimension_; ++a) {
    if (candidates[a].smaller == 0 || candidates[a].smaller < most - most / 10) continue;
    if (axis < 0 || candidates[a].length > candidates[axis].length) axis = a;
  }

  const TileId added{tiles()};
  const double value = candidates[axis].split.value;
  const auto row = static_cast<std::int32_t>(nodes_.size());
  for (SplitNode& node : nodes_) {
    for (std::int32_t& child : node.child) {
      if (child == as_leaf(tile)) child = row;
    }
  }
  nodes_.push_back({value, axis, {as_leaf(tile), as_leaf(added)}});
  Box above = boxes_[tile.value];
  above.lo[axis] = value;
  boxes_[tile.value].hi[axis] = value;
  boxes_.push_back(above);
  return true;
}

TileLayout layout_of(const Partition& partition, const Bounds& bounds) {
  TileLayout layout{partition.dimension(), bounds, {}};
  for (const SplitNode& node : partition.splits())
    layout.cuts.push_back({node.value, node.axis, node.child[0], node.child[1]});
  return layout;
}

}  // namespace tessera
