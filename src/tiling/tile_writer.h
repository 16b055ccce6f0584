// Sorts a stream of points into bundles.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/tiling/partition.h"
#include "src/tiling/routed_points.h"
#include "src/tiling/shuffle_file.h"

namespace tessera {

// Collects points in one buffer; when it is full, it is sorted by tile and becomes a bundle.
class TileWriter {
 public:
  // `attempt`: nobody else writes bundles of that one. `buffer_bytes`: memory to use, at least for a few thousand
  // points.
  TileWriter(std::filesystem::path run_folder, std::uint32_t attempt, int dimension, std::size_t row_bytes,
             std::uint64_t buffer_bytes);

  // What a point costs in the buffer.
  static std::uint64_t bytes_per_point(std::size_t row_bytes) { return sizeof(LocalPoint) + row_bytes + 8; }

  // REQUIRES: rows.size() == points.size() * row_bytes; ids ascend within a tile; the partition only grows from call to
  // call.
  Status add(const Partition& partition, std::span<const LocalPoint> points, std::span<const std::byte> rows);
  Status flush(const Partition& partition);

  // What has been flushed.
  RoutedPoints& routed() { return routed_; }

 private:
  template <class Seen>
  Status write(const std::filesystem::path& path, std::span<const std::byte> records, std::span<const TileId> filled,
               std::uint64_t Segment::*sum, Seen seen);

  std::filesystem::path folder_;
  std::uint32_t attempt_, bundles_ = 0;
  std::size_t row_bytes_;
  std::size_t capacity_;  // points; < 2^32
  std::vector<LocalPoint> points_;
  std::vector<std::byte> rows_;
  std::vector<TileId> tiles_;
  std::vector<std::uint32_t> by_tile_;  // indices into points_, by tile and then in order of arrival
  std::vector<std::byte> block_;
  RoutedPoints routed_;
};

}  // namespace tessera
