// What tiles leave behind, in memory: it outlives the harness's processes as a disk would, and fails when it is told
// to.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "actors/harness/memory_faults.h"
#include "src/run/tile_storage.h"

namespace tessera {

// The k-th call of a kind fails once.
struct StorageFault {
  enum class Call : std::uint8_t { load, write, append, read, remove, store };
  enum class How : std::uint8_t { error, exception, no_memory };
  Call call = Call::write;
  How how = How::error;
  std::uint64_t countdown = 0;
};

class MemoryStorage final : public TileStorage {
 public:
  MemoryStorage(int dimension, std::vector<std::vector<LocalPoint>> points)
      : dimension_(dimension), points_(std::move(points)) {}

  Result<LoadedTile> load_points(TileId tile) override;
  Status write(TileId tile, ScratchKind what, std::span<const std::byte> bytes) override;
  Status append(TileId tile, ScratchKind what, std::span<const std::byte> bytes) override;
  Result<Pieces> read(TileId tile, ScratchKind what) override;
  Result<bool> has(TileId tile, ScratchKind what) override { return scratch_.contains({tile, what}); }
  Status remove(TileId tile, ScratchKind what) override;
  Status clear(ScratchKind what) override;
  void store(TileId tile, TileMesh mesh, Stored done) override;

  // Meshes that wait to be stored, as long as nobody calls store_one(). False when there are none.
  bool late_stores = false;
  bool store_one(std::mt19937_64& rng);
  // What is on its way is lost with the process, which ends in order. False when nothing was.
  bool lose_pending();
  // One thing on scratch, chosen at random, cannot be read from now on.
  void damage(std::mt19937_64& rng);

  std::optional<StorageFault> fault;
  MemoryFaults* memory_faults = nullptr;
  bool settled = false;  // the marker of the run

  const std::map<TileId, TileMesh>& meshes() const { return meshes_; }
  // Whether any mail is left.
  bool holds_mail() const;
  std::uint64_t spills() const { return spills_; }
  // How often a tile's points, or its scratch of one kind, were read at most since this was asked last.
  std::uint64_t take_reads();

 private:
  struct Scratch {
    Pieces pieces;
    bool damaged = false;
  };
  struct Pending {
    TileId tile;
    TileMesh mesh;
    Stored done;
  };
  Status maybe_fail(StorageFault::Call call);
  void store_now(Pending pending);

  int dimension_;
  std::vector<std::vector<LocalPoint>> points_;
  std::map<std::pair<TileId, ScratchKind>, Scratch> scratch_;
  std::vector<Pending> pending_;
  std::map<TileId, TileMesh> meshes_;
  std::uint64_t spills_ = 0;
  std::map<std::pair<TileId, std::optional<ScratchKind>>, std::uint64_t> reads_;  // no kind: of its points
};

}  // namespace tessera
