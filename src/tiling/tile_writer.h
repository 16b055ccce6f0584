// Sorts a stream of points into the files of their tiles.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/tiling/partition.h"
#include "src/tiling/seed_finder.h"
#include "src/tiling/tile_sums.h"

namespace tessera {

// Collects points in one buffer; when it is full, every tile that has some gets them appended to its file. One file is
// open at a time, and writes are large when the buffer is: 128 MB over 1000 tiles are 100 KB each.
class TileWriter {
 public:
  // `buffer_bytes`: memory to use, at least for a few thousand points.
  TileWriter(std::filesystem::path run_folder, int dimension, std::size_t row_bytes, std::uint64_t buffer_bytes);

  // What a point costs in the buffer.
  static std::uint64_t bytes_per_point(std::size_t row_bytes) { return sizeof(LocalPoint) + row_bytes + 8; }

  // REQUIRES: rows.size() == points.size() * row_bytes; the partition only grows from call to call.
  Status add(const Partition& partition, std::span<const LocalPoint> points, std::span<const std::byte> rows);
  Status flush(const Partition& partition);
  // Forgets what a tile had, whose files the caller has taken away.
  void restart(TileId tile);

  // By tile, of what has been flushed.
  std::vector<std::uint64_t>& counts() { return counts_; }
  std::vector<Bounds>& bounds() { return bounds_; }
  std::vector<TileSums>& sums() { return sums_; }
  const SeedFinder& seeds() const { return seeds_; }

 private:
  Status append(TileId tile, const Box& box, std::span<const std::uint32_t> rows);

  std::filesystem::path folder_;
  std::size_t row_bytes_;
  std::size_t capacity_;  // points; < 2^32
  std::vector<LocalPoint> points_;
  std::vector<std::byte> rows_;
  std::vector<TileId> tiles_;
  std::vector<std::uint32_t> by_tile_;  // indices into points_, by tile and then in order of arrival
  std::vector<std::byte> block_;
  std::vector<std::uint64_t> counts_;
  std::vector<Bounds> bounds_;
  std::vector<TileSums> sums_;
  SeedFinder seeds_;
};

}  // namespace tessera
