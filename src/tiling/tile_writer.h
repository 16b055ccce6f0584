// Sorts a stream of points into shuffle files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "src/base/image.h"
#include "src/base/point.h"
#include "src/base/result.h"
#include "src/tiling/partition.h"
#include "src/tiling/routed_points.h"
#include "src/tiling/shuffle_file.h"

namespace tessera {

// Collects points in one buffer. A full buffer is sorted by tile and becomes a shuffle file.
class TileWriter {
 public:
  // `attempt`: no other writer of the run has it, so no other writer has files of these names. `buffer_bytes`: memory
  // to use; it is raised to what a few thousand points need.
  TileWriter(std::filesystem::path run_folder, std::uint32_t attempt, int dimension, std::size_t row_bytes,
             std::uint64_t buffer_bytes, const Period& period = {});

  // Bytes that a point needs in the buffer.
  static std::uint64_t bytes_per_point(std::size_t row_bytes) { return sizeof(LocalPoint) + row_bytes + 8; }

  // Adds points. REQUIRES: rows.size() == points.size() * row_bytes; ids ascend within a tile; from call to call the
  // partition only grows.
  Status add(const Partition& partition, std::span<const LocalPoint> points, std::span<const std::byte> rows);
  Status flush(const Partition& partition);

  // The account of what has been flushed.
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
