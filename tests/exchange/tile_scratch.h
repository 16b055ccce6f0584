// What one life of a tile has on disk, in memory.
#pragma once

#include <map>
#include <span>

#include "src/exchange/tile_storage.h"

namespace tessera::testing {

class TileScratch : public TileStorage {
 public:
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
  // As an earlier process leaves it: but for mail.
  void inherit(const TileScratch& other) {
    pieces_ = other.pieces_;
    pieces_.erase(ScratchKind::mail);
  }

 private:
  std::map<ScratchKind, Pieces> pieces_;
};

}  // namespace tessera::testing
