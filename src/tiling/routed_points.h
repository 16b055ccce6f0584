// What is known of routed points, whichever process has routed them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "src/base/image.h"
#include "src/base/point.h"
#include "src/input/cloud/cloud.h"
#include "src/tiling/affine_basis.h"
#include "src/tiling/seed_finder.h"
#include "src/tiling/shuffle_file.h"

namespace tessera {

// The account of points that were routed to tiles: where they are, their bounds, and candidates for seeds.
struct RoutedPoints {
  explicit RoutedPoints(int dimension, const Period& period = {}) : seeds(dimension, period), span(dimension, period) {}

  std::vector<ShuffleFile> bundles;
  std::vector<std::vector<Segment>> segments;  // by tile
  std::vector<Bounds> bounds;                  // by tile: the bounds of its points
  SeedFinder seeds;
  AffineBasis span;
  CloudCounts counts;                   // of the input
  std::vector<std::uint64_t> of_files;  // by input file: how many of its points were read

  void resize(std::uint32_t tiles);
  std::uint64_t points_of(TileId tile) const;
  // Adds the account of the next input split. The ids in `next` count from its first point; they are moved to go on
  // where the ids of this account end. Appending all input splits in order makes the account of one pass over the whole
  // input.
  void append(const RoutedPoints& next);
  // Removes a tile's points from the account, and returns their segments. The records stay on disk.
  std::vector<Segment> take(TileId tile);
};

// The account as bytes, for the network or a file. from_bytes() trusts nothing: it returns false when the bytes are not
// what to_bytes() makes of an account of `tiles` tiles.
BigVector<std::byte> to_bytes(const RoutedPoints& routed);
bool from_bytes(std::span<const std::byte> bytes, std::uint32_t tiles, RoutedPoints& routed);

}  // namespace tessera
