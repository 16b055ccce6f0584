// Storage for tiles, in memory. It outlives the simulated processes, as a disk would, and fails when it is told to.
#pragma once

#include <compare>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "actors/harness/memory_faults.h"
#include "src/delaunay/delaunay_store.h"
#include "src/exchange/tile_storage.h"

namespace tessera {

// A fault: the call of this kind after `countdown` others fails, once.
struct StorageFault {
  enum class Call : std::uint8_t { load, write, append, read, remove, store };
  enum class How : std::uint8_t { error, exception, no_memory };
  Call call = Call::write;
  How how = How::error;
  std::uint64_t countdown = 0;
};

// What all nodes see, as a shared folder (points, what makes tiles independent, results), and the scratch of each node,
// which no other node reads.
class MemoryStorage {
 public:
  MemoryStorage(int dimension, std::vector<std::vector<LocalPoint>> points);
  ~MemoryStorage();

  // Returns the storage as a node sees it. It outlives the shares that use it.
  TileStorage& at(NodeId node, std::uint32_t stage = 0);
  DelaunayStore& store_at(NodeId node);
  // Removes what makes tiles independent in a stage.
  void forget_settled(std::uint32_t stage);

  // Late stores: finished tiles wait until store_one() is called, which stores a random one of them. It returns false
  // when none waits.
  bool late_stores = false;
  bool store_one(std::mt19937_64& rng);
  // The process ends in order, and tiles that wait to be stored are lost. Returns false when there were none.
  bool lose_pending();
  // Damages one thing on scratch, at random: it cannot be read from now on.
  void damage(std::mt19937_64& rng);

  std::optional<StorageFault> fault;
  MemoryFaults* memory_faults = nullptr;
  std::uint32_t settled = 0;  // number of settled stages: the markers of the run
  // Nodes have scratch of their own. When the scratch of one fails, others can go on.
  bool many_nodes = false;
  const std::set<NodeId>& failed() const { return failed_; }  // nodes whose scratch has failed

  const std::map<TileId, TileMesh>& meshes() const { return meshes_; }
  std::vector<TileReceipt> stored() const;
  // Returns whether any mail is left.
  bool holds_mail() const;
  std::uint64_t spills() const { return spills_; }
  // Returns how often one tile's points, or its scratch of one kind, were read at most since the last call.
  std::uint64_t take_reads();
  // Returns how often one tile has begun from its points, and not from what was handed over, at most since the last
  // call.
  std::uint64_t take_begun();

 private:
  class AtNode;
  struct StorageKey {
    std::optional<NodeId> node;  // none: all nodes see it
    TileId tile;
    ScratchKind what = ScratchKind::state;
    std::uint32_t stage = 0;
    friend auto operator<=>(const StorageKey&, const StorageKey&) = default;
  };
  static StorageKey key_of(NodeId node, std::uint32_t stage, TileId tile, ScratchKind what);
  struct Scratch {
    TileStorage::Pieces pieces;
    bool damaged = false;
  };
  struct Early {
    std::vector<std::int32_t> vertices, neighbors;
  };
  struct Pending {
    NodeId node;
    TileId tile;
    TileMesh mesh;
    Finished::Stored done;
  };
  Status maybe_fail(StorageFault::Call call);
  // The same for the scratch of a node. Notes that the scratch has failed.
  Status maybe_fail(StorageFault::Call call, NodeId node, ScratchKind what);
  void store_now(Pending pending);

  int dimension_;
  std::vector<std::vector<LocalPoint>> points_;
  std::map<StorageKey, Scratch> scratch_;
  std::map<std::pair<TileId, NodeId>, Early> early_;  // visible to all nodes
  AtNode& view_of(NodeId node, std::uint32_t stage);

  std::map<std::pair<NodeId, std::uint32_t>, std::unique_ptr<AtNode>> views_;
  std::vector<Pending> pending_;
  std::map<TileId, TileMesh> meshes_;
  std::uint64_t spills_ = 0;
  std::set<NodeId> failed_;
  // By stage, tile and kind of scratch; no kind: the tile's points.
  std::map<std::tuple<std::uint32_t, TileId, std::optional<ScratchKind>>, std::uint64_t> reads_;
  std::map<std::pair<std::uint32_t, TileId>, std::uint64_t> begun_;
};

}  // namespace tessera
