// One tile's life without CAF: what its actor does between messages. Not thread-safe: one actor owns it.
//
//   fresh -- triangulate --> awake -- sleep --> asleep
//                            awake <-- (splay or collect wakes it) -- asleep
//                            awake -- collect --> collected
// Mail may come in any state but collected, and waits until splay().
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "actors/tile_storage.h"
#include "src/base/progress.h"
#include "src/base/result.h"
#include "src/quiescence/counters.h"
#include "src/tile/tile_triangulation.h"

namespace tessera {

// Shared by all tiles of a run, read-only.
struct TileContext {
  int dimension = 3;
  KernelKind kernel = KernelKind::flat;
  // Hand out final cells and keep the rest only: a tenth of the memory, a tenth more work.
  bool reduce = false;
  std::vector<Box> boxes;                              // by tile; a tile with the empty box has no final cells
  std::vector<std::vector<TileNeighbour>> neighbours;  // by tile: whom it tells first
  std::vector<SharedPoint> seeds;
  TileStorage* storage = nullptr;
  Progress* progress = nullptr;
};

// Points from one tile to another.
struct Batch {
  Peer from, to;
  std::uint32_t hops = 0;
  std::vector<SharedPoint> points;
};

class TileState {
 public:
  TileState(Peer self, const TileContext& context);

  Status triangulate();
  void receive(Batch batch);
  // Processes all mail that waits. No batch is counted as processed before its points are in.
  Status splay();
  Status sleep();
  // What is to be stored. The tile has no triangulation any more.
  Result<TileMesh> collect();

  // Updates the others must get, by now counted as sent.
  std::vector<Batch> take_outgoing();

  bool asleep() const { return phase_ == Phase::asleep; }
  std::uint64_t waiting_points() const { return waiting_points_; }
  Totals totals() const { return counters_.totals(); }
  std::size_t memory() const;
  const ExchangeCounts& counts() const { return counts_; }
  std::uint32_t hops() const { return hops_; }
  // (duplicate, kept), known after triangulate().
  std::vector<std::pair<std::uint64_t, std::uint64_t>> take_duplicates() { return std::move(duplicates_); }
  std::uint64_t own_points() const { return own_points_; }

 private:
  enum class Phase : std::uint8_t { fresh, awake, asleep, collected };
  struct Waiting {
    TileId from;
    std::vector<SharedPoint> points;
  };

  Status wake();
  Status spill_mail();
  Result<std::vector<Waiting>> take_mail();
  Status put_finals(const FinalCells& finals);
  Result<FinalCells> take_finals();
  TileOptions options() const { return {self_.tile, context_.dimension, context_.kernel, ExchangeRule::share_certify}; }

  Peer self_;
  const TileContext& context_;
  Phase phase_ = Phase::fresh;
  std::unique_ptr<TileTriangulation> triangulation_;
  LoadedTile points_;  // kept while the context does not reduce
  std::uint64_t own_points_ = 0;
  std::vector<Waiting> mail_;
  std::uint64_t mail_points_ = 0;     // in mail_
  std::uint64_t waiting_points_ = 0;  // in mail_ and spilled
  std::vector<Peer> waiting_peers_;   // one per waiting batch: counted as processed by splay()
  std::uint32_t waiting_hops_ = 0;    // longest chain among them
  std::uint32_t hops_ = 0;            // longest chain of messages that reached this tile
  PeerCounters counters_;
  ExchangeCounts counts_;
  std::vector<std::pair<std::uint64_t, std::uint64_t>> duplicates_;
};

}  // namespace tessera
