// What tiles leave behind, in memory: it outlives the harness's processes as a disk would, and fails when it is told
// to.
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

// The k-th call of a kind fails once.
struct StorageFault {
  enum class Call : std::uint8_t { load, write, append, read, remove, store };
  enum class How : std::uint8_t { error, exception, no_memory };
  Call call = Call::write;
  How how = How::error;
  std::uint64_t countdown = 0;
};

// What all nodes see, as a shared folder: points, what makes tiles independent, results; and the scratch of each node,
// which no other reads.
class MemoryStorage {
 public:
  MemoryStorage(int dimension, std::vector<std::vector<LocalPoint>> points);
  ~MemoryStorage();

  // As a node sees it. It outlives the parts that use it.
  TileStorage& at(NodeId node, std::uint32_t stage = 0);
  DelaunayStore& store_at(NodeId node);
  // What makes tiles independent in a stage goes.
  void forget_settled(std::uint32_t stage);

  // Meshes that wait to be stored, as long as nobody calls store_one(). False when there are none.
  bool late_stores = false;
  bool store_one(std::mt19937_64& rng);
  // What is on its way is lost with the process, which ends in order. False when nothing was.
  bool lose_pending();
  // One thing on scratch, chosen at random, cannot be read from now on.
  void damage(std::mt19937_64& rng);

  std::optional<StorageFault> fault;
  MemoryFaults* memory_faults = nullptr;
  std::uint32_t settled = 0;  // so many stages of the run: its markers
  // Nodes have scratch of their own: when that fails, others can go on.
  bool many_nodes = false;
  const std::set<NodeId>& failed() const { return failed_; }  // those whose scratch has

  const std::map<TileId, TileMesh>& meshes() const { return meshes_; }
  std::vector<TileReceipt> stored() const;
  // Whether any mail is left.
  bool holds_mail() const;
  std::uint64_t spills() const { return spills_; }
  // How often a tile's points, or its scratch of one kind, were read at most since this was asked last.
  std::uint64_t take_reads();
  // How often a tile has begun from its points at most since this was asked last, and not from what was handed over.
  std::uint64_t take_begun();

 private:
  class AtNode;
  struct Place {
    std::optional<NodeId> node;  // none: all see it
    TileId tile;
    ScratchKind what = ScratchKind::state;
    std::uint32_t stage = 0;
    friend auto operator<=>(const Place&, const Place&) = default;
  };
  static Place place_of(NodeId node, std::uint32_t stage, TileId tile, ScratchKind what);
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
  // On the scratch of a node, which is not asked any more when it has failed.
  Status maybe_fail(StorageFault::Call call, NodeId node, ScratchKind what);
  void store_now(Pending pending);

  int dimension_;
  std::vector<std::vector<LocalPoint>> points_;
  std::map<Place, Scratch> scratch_;
  std::map<std::pair<TileId, NodeId>, Early> early_;  // all see them
  AtNode& view_of(NodeId node, std::uint32_t stage);

  std::map<std::pair<NodeId, std::uint32_t>, std::unique_ptr<AtNode>> views_;
  std::vector<Pending> pending_;
  std::map<TileId, TileMesh> meshes_;
  std::uint64_t spills_ = 0;
  std::set<NodeId> failed_;
  // By stage. No kind: of its points.
  std::map<std::tuple<std::uint32_t, TileId, std::optional<ScratchKind>>, std::uint64_t> reads_;
  std::map<std::pair<std::uint32_t, TileId>, std::uint64_t> begun_;
};

}  // namespace tessera
