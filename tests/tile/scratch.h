// What one life of a tile has on disk, in memory.
#pragma once

#include <map>
#include <span>
#include <utility>
#include <vector>

#include "src/run/tile_program.h"

namespace tessera::testing {

class Scratch final : public TileStorage {
 public:
  Scratch(std::vector<LocalPoint> points, int dimension) : points_(std::move(points)), dimension_(dimension) {}
  Result<LoadedTile> load_points(TileId) override { return order_points(points_, dimension_); }
  Status write(TileId, ScratchKind what, std::span<const std::byte> bytes) override {
    pieces_[what] = {{bytes.begin(), bytes.end()}};
    return success();
  }
  Status append(TileId, ScratchKind what, std::span<const std::byte> bytes) override {
    pieces_[what].emplace_back(bytes.begin(), bytes.end());
    return success();
  }
  Result<Pieces> read(TileId, ScratchKind what) override { return pieces_[what]; }
  Result<bool> has(TileId, ScratchKind what) override { return !pieces_[what].empty(); }
  Status remove(TileId, ScratchKind what) override {
    pieces_.erase(what);
    return success();
  }
  Status clear(ScratchKind what) override { return remove({}, what); }
  std::future<StoredEarly> store_early(TileId, std::shared_ptr<const EarlyFinals>) override { return {}; }
  Status take_early(TileId, BigVector<std::byte>&) override { return success(); }
  void store(TileId, CollectedTile tile, Stored) override { stored_ = std::move(tile); }
  // What a tile that has come to its end gives to the storage.
  TileMesh mesh_of(Finished& finished) {
    finished.store(*this, {}, {});
    return std::move(stored_).whole();
  }
  // As an earlier process leaves it: but for mail.
  void inherit(const Scratch& other) {
    pieces_ = other.pieces_;
    pieces_.erase(ScratchKind::mail);
  }

 private:
  std::vector<LocalPoint> points_;
  int dimension_;
  std::map<ScratchKind, Pieces> pieces_;
  CollectedTile stored_;
};

}  // namespace tessera::testing
