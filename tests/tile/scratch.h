// What one life of a Delaunay tile begins from, has on disk, and ends as, in memory.
#pragma once

#include <utility>
#include <vector>

#include "src/delaunay/delaunay_store.h"
#include "tests/exchange/tile_scratch.h"

namespace tessera::testing {

class Scratch final : public TileScratch, public DelaunayStore {
 public:
  Scratch(std::vector<LocalPoint> points, int dimension) : points_(std::move(points)), dimension_(dimension) {}
  Result<LoadedTile> load_points(TileId) override { return order_points(points_, dimension_); }
  std::future<StoredEarly> store_early(TileId, std::shared_ptr<const EarlyFinals>) override { return {}; }
  Status take_early(TileId, BigVector<std::byte>&) override { return success(); }
  void store(TileId, CollectedTile tile, Finished::Stored) override { stored_ = std::move(tile); }
  void store_points(TileId, PointsOfTile, Finished::Stored) override {}
  // What a tile that has come to its end gives to the store.
  TileMesh mesh_of(Finished& finished) {
    finished.store({});
    return std::move(stored_).whole();
  }

 private:
  std::vector<LocalPoint> points_;
  int dimension_;
  CollectedTile stored_;
};

}  // namespace tessera::testing
