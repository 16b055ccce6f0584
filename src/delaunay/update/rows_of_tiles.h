// The attributes of the vertices of a result that is changed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <tsl/robin_map.h>

#include "src/base/mix_hash.h"
#include "src/base/result.h"
#include "src/delaunay/update/update_plan.h"
#include "src/result/tile_source.h"

namespace tessera {

// Keeps the attributes of the tiles that were read last, because the foreign vertices of a tile belong to its
// neighbours. Thread-safe.
class RowsOfTiles {
 public:
  // `memory_bytes`: for what is kept.
  RowsOfTiles(TileSource source, std::shared_ptr<const UpdatePlan> plan, std::uint64_t memory_bytes)
      : source_(std::move(source)), plan_(std::move(plan)), memory_bytes_(memory_bytes) {}

  // Returns the attributes of vertices of this tile's cells: ids.size() rows of the schema. `owners`: beside ids. They
  // are in the plan for new points and for duplicates that have become vertices, else in the tile's own file, or in
  // that of the owner. Error internal when a vertex is in none of them; those of reading the tiles.
  Result<std::vector<std::byte>> of(TileId tile, std::span<const PointId> ids, std::span<const TileId> owners);

 private:
  struct OfTile {
    TileId tile;
    tsl::robin_map<PointId, std::size_t, MixHash> places;
    std::vector<std::byte> rows;
    std::uint64_t bytes() const { return rows.size() + places.bucket_count() * 24 + sizeof(OfTile); }
  };
  // Null when the result does not have the tile.
  Result<std::shared_ptr<const OfTile>> read(TileId tile);
  void keep(std::shared_ptr<const OfTile> rows);

  TileSource source_;
  std::shared_ptr<const UpdatePlan> plan_;
  std::uint64_t memory_bytes_;
  std::mutex mutex_;
  std::list<std::shared_ptr<const OfTile>> kept_;  // the last one used first
  std::uint64_t kept_bytes_ = 0;
};

}  // namespace tessera
