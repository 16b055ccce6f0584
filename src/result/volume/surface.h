// A 2D result as a surface over the plane, read tile by tile.
#pragma once

#include <array>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "src/base/result.h"
#include "src/result/export/cell_filter.h"
#include "src/result/query/column.h"
#include "src/result/tile_source.h"
#include "src/result/volume/box_tree.h"
#include "src/result/volume/facet.h"

namespace tessera::volume {

// The main cells of a tile that belong to the surface.
class SurfaceTile {
 public:
  std::size_t size() const { return cells_.size(); }
  Facet facet(std::size_t i) const {
    const auto& cell = cells_[i];
    return canonical({points_[cell[0]], points_[cell[1]], points_[cell[2]]});
  }
  const FlatBox& box() const { return box_; }  // REQUIRES: there is a cell
  const BoxTree& tree() const { return tree_; }
  std::size_t bytes() const {
    return points_.size() * sizeof(Point) + cells_.size() * sizeof(cells_[0]) + tree_.bytes();
  }
  std::uint64_t long_edges() const { return long_edges_; }          // cells left out because of their edges
  std::uint64_t without_height() const { return without_height_; }  // ... of a vertex whose height is not finite

 private:
  friend class Surface;
  std::vector<Point> points_;  // z: the height
  std::vector<std::array<std::uint32_t, 3>> cells_;
  FlatBox box_;
  BoxTree tree_;
  std::uint64_t long_edges_ = 0, without_height_ = 0;
};

class Surface {
 public:
  // `value` is the attribute with the heights. Errors: those of reading a manifest; usage for a 3D result, a result
  // without this attribute, and a length that is none.
  static Result<Surface> open(const std::filesystem::path& out, const std::string& value,
                              const exports::CellSizes& sizes);

  const Manifest& manifest() const { return source_.manifest(); }
  const TileSource& source() const { return source_; }
  // The tiles that own a vertex of a cell that meets the box; without a box, all.
  Result<std::vector<std::size_t>> tiles(const std::optional<FlatBox>& box, std::uint64_t memory_bytes,
                                         const std::stop_token& stop) const;
  // Errors: corrupt, io, memory.
  Result<SurfaceTile> read(std::size_t tile) const;

 private:
  Surface(TileSource source, query::Column column, const exports::CellSizes& sizes)
      : source_(std::move(source)), column_(column), filter_(sizes) {}

  TileSource source_;
  query::Column column_;
  exports::CellFilter filter_;
};

// Keeps tiles of a surface in memory, as many as a budget allows. The least recently used are dropped first.
// Thread-safe.
class SurfaceCache {
 public:
  SurfaceCache(const Surface& surface, std::uint64_t bytes_max) : surface_(surface), bytes_max_(bytes_max) {}

  // Returns the tile from memory or reads it. One thread reads, and others that want the tile wait. Errors: as read().
  Result<std::shared_ptr<const SurfaceTile>> get(std::size_t tile);

 private:
  struct Slot {
    std::shared_ptr<const SurfaceTile> tile = {};
    bool loading = false;
    std::uint64_t used = 0;  // the higher, the later
  };
  void evict();  // REQUIRES: the lock is held

  const Surface& surface_;
  std::uint64_t bytes_max_;
  std::mutex mutex_;
  std::condition_variable loaded_;
  std::map<std::size_t, Slot> slots_;
  std::uint64_t bytes_ = 0, clock_ = 0;
};

}  // namespace tessera::volume
