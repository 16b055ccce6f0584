// The attributes of the points of a live result. Those of stored vertices are in the files of the result. All others
// are in memory: those of points that were added since, of duplicates, and of duplicates that became vertices.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

#include "src/base/ids.h"
#include "src/base/result.h"
#include "src/result/tile_source.h"

namespace tessera {

// Not thread-safe.
class LiveRows {
 public:
  using Rows = std::map<PointId, std::vector<std::byte>>;

  // Whether the attributes of all duplicates are known, because the result has attributes, and no older software has
  // made it that did not keep them.
  bool complete() const { return complete_; }
  void set_complete(bool complete) { complete_ = complete; }

  // A duplicate of the stored result.
  void add_stored(PointId duplicate, std::span<const std::byte> row) { put(duplicates_, duplicate, row); }
  // A new point, or a stored vertex that becomes a duplicate.
  void add(PointId id, std::span<const std::byte> row) { put(unstored_, id, row); }
  // A duplicate becomes a vertex.
  void promote(PointId duplicate);
  void remove(PointId id);
  // Nothing is known any more but the attributes of these duplicates: everything is stored.
  void store(std::span<const DuplicatePair> duplicates);

  // Null when the attributes of the point are stored, or not known.
  const std::vector<std::byte>* find(PointId id) const;
  // Those of vertices among them.
  const Rows& unstored() const { return unstored_; }
  // `width`: bytes of a row.
  std::size_t memory(std::size_t width) const { return (unstored_.size() + duplicates_.size()) * (96 + width); }

 private:
  static void put(Rows& rows, PointId id, std::span<const std::byte> row) { rows[id].assign(row.begin(), row.end()); }
  Rows unstored_, duplicates_;
  bool complete_ = false;
};

// The attributes of the vertices of one stored tile, foreign ones included.
class RowsOfTile {
 public:
  // `rows`: beside `ids`.
  RowsOfTile(std::span<const PointId> ids, std::vector<std::byte> rows);
  // Empty when the tile does not have the vertex.
  std::span<const std::byte> find(PointId id) const;
  std::size_t bytes() const { return places_.capacity() * sizeof places_[0] + rows_.capacity(); }

 private:
  std::vector<std::pair<PointId, std::uint32_t>> places_;  // ascending
  std::vector<std::byte> rows_;
};

// Reads the attributes of stored tiles, and keeps those of some tiles for the next question. Thread-safe.
class StoredRows {
 public:
  static constexpr std::size_t kept_bytes = std::size_t{64} << 20;
  // `source`: without columns.
  explicit StoredRows(TileSource source) : source_(std::move(source)) {}
  // Empty for a tile that is not stored. Errors: those of reading.
  Result<std::shared_ptr<const RowsOfTile>> of(TileId tile);

 private:
  const TileSource source_;
  std::mutex mutex_;
  std::map<TileId, std::shared_ptr<const RowsOfTile>> kept_;
  std::size_t bytes_ = 0;
};

}  // namespace tessera
