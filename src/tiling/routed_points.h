// What is known of points that were routed, whoever has routed them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "src/base/point.h"
#include "src/input/cloud/cloud.h"
#include "src/tiling/seed_finder.h"
#include "src/tiling/shuffle_file.h"
#include "src/tiling/span_finder.h"

namespace tessera {

struct RoutedPoints {
  explicit RoutedPoints(int dimension) : seeds(dimension), span(dimension) {}

  std::vector<ShuffleFile> bundles;
  std::vector<std::vector<Segment>> segments;  // by tile
  std::vector<Bounds> bounds;                  // by tile, of its points
  SeedFinder seeds;
  SpanFinder span;
  CloudCounts counts;  // of the input

  void resize(std::uint32_t tiles);
  std::uint64_t points_of(TileId tile) const;
  // The next stretch of the input: ids in it count from its first point, and go on here where these end. One after the
  // other they make what one would have found who routed all.
  void append(const RoutedPoints& next);
  // Takes a tile's points out of the account. Their records stay where they are.
  std::vector<Segment> take(TileId tile);
};

// Across a network, or as files. The reader trusts nothing: false when they are not what to_bytes() gives of
// `tiles` tiles.
BigVector<std::byte> to_bytes(const RoutedPoints& routed);
bool from_bytes(std::span<const std::byte> bytes, std::uint32_t tiles, RoutedPoints& routed);

}  // namespace tessera
