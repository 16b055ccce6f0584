// The life of one tile between messages, whatever its program does. Not thread-safe: one actor owns it.
//
//   fresh -- begin --> awake -- sleep --> asleep
//                      awake <-- (step or finish wakes it) -- asleep
//                      awake, asleep, fresh -- finish --> gone
//                      awake, asleep -- drop, hand_over --> gone
// Mail may come in any state but gone, and waits until step(). Mail for a tile that was handed over is dropped. A fresh
// tile is finished when the run was settled before: what the tile has settled is then all that it needs
// (docs/design.md, section 3).
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "src/base/result.h"
#include "src/exchange/counters.h"
#include "src/exchange/inbox.h"
#include "src/exchange/routing_table.h"
#include "src/exchange/tile_program.h"
#include "src/exchange/tile_storage.h"
#include "src/exchange/update.h"

namespace tessera {

// Is told of every update. The harness uses it to check that nothing is believed quiet that is not.
class ExchangeWatch {
 public:
  virtual ~ExchangeWatch() = default;
  // `now` has the totals of the tile that has sent, has processed, or has got a new table.
  virtual void sent(TileIncarnation from, TileIncarnation to, Totals now) = 0;
  virtual void processed(TileIncarnation from, TileIncarnation to, Totals now) = 0;
  virtual void rejoined(TileIncarnation self, Totals now) = 0;
};

// What all tiles of a job on one node have in common in a stage. Read-only.
struct TileContext {
  std::shared_ptr<const TilePrograms> programs;
  bool many_nodes = false;                           // other nodes cannot use images of this one, so every tile settles
  std::uint64_t mail_bytes_max = ~std::uint64_t{0};  // how many bytes of mail a tile keeps in memory
  TileStorage* storage = nullptr;
  ExchangeWatch* watch = nullptr;
};

class TileLife {
 public:
  // `table` is the routing table with which the tile begins.
  TileLife(TileIncarnation self, const TileContext& context, std::shared_ptr<const RoutingTable> table);

  // Begins from the image that an earlier process has left, if it is sound; else from the image that another node has
  // handed over; else from what the stage before has left.
  Status begin();
  // Takes an update into the mail. Drops it when its sender is dead, or when it was sent to an earlier life of this
  // tile.
  Status receive(Update update);
  // Goes by `table` from now on. In it some tiles were reborn, and nothing from their dead incarnations counts any
  // more. A tile that has begun calls itself to a step (take_outgoing()), in which it first tells the reborn tiles
  // again what may have been lost. Allowed in any state. Touches neither the program nor scratch, so it is fast. A
  // table that is no newer than the tile's changes nothing. `rebirths` has all changes from the tile's table, or an
  // earlier one, up to `table`; it may be null when the tile has not begun.
  void rejoin(std::shared_ptr<const RoutingTable> table, const IncarnationChanges* rebirths);
  // Processes all mail that waits. An update counts as processed only after the program has worked on it.
  Status step();
  // Writes an image to scratch, and frees the memory. A resumed run begins from this image, too.
  Status sleep();
  // Writes an image where other nodes find it. The tile goes on from it on another node, as another incarnation. Mail
  // that has come and was not processed is dropped, because its senders tell it again. The tile is gone even when an
  // error is returned.
  Status hand_over();
  // After quiescence: writes down what finish() of a fresh tile needs, unless an image has it.
  Status settle();
  // Ends the stage and returns what is kept. The tile is gone, and its program is freed.
  Result<std::unique_ptr<Finished>> finish();
  // Removes what waits on scratch, because the tile may come back to this node as another incarnation. REQUIRES: the
  // tile is fresh.
  Status leave();
  // Frees the memory of a tile that need not be finished.
  void drop();

  // Returns the updates that are to be sent to other tiles, or to this one. They count as sent from now on.
  std::vector<Update> take_outgoing();

  std::uint64_t waiting_updates() const { return inbox_.updates(); }
  std::uint64_t waiting_bytes() const { return inbox_.bytes(); }
  // The length of the longest chain of updates that ends with a waiting one.
  std::uint32_t waiting_hops() const { return waiting_hops_; }
  std::uint64_t mail_memory() const { return inbox_.memory(); }
  Totals totals() const { return counters_.totals(); }
  std::uint64_t updates_sent() const { return updates_sent_; }
  std::size_t memory() const { return program_->memory() + inbox_.memory() + counters_.memory(); }
  const ExchangeCounts& counts() const { return program_->counts(); }
  std::uint32_t hops() const { return hops_; }  // length of the longest chain of updates that reached this tile

 private:
  enum class State : std::uint8_t { fresh, awake, asleep, gone };

  // Returns what `work` returns. When `work` throws Unsound, returns an error instead: what was read from scratch has
  // sound checksums, but cannot be worked with. It is removed, so that no tile begins from it again.
  template <class Work>
  auto with_what_was_read(const Work& work) -> decltype(work());
  Status begin_somehow();
  Status begin_settled();
  Result<bool> restore(ImageOf whose);
  Result<bool> restore_handed();
  Status process_mail();
  Status wake();
  Status write_handed();
  bool dead(const Update& update) const { return update.to != self_ || table_->dead(update.from); }
  Update outgoing(TileIncarnation to, Message message);

  TileIncarnation self_;
  const TileContext& context_;
  std::shared_ptr<const RoutingTable> table_;
  std::unique_ptr<TileProgram> program_;
  std::vector<TileId> reborn_;  // since the last step; a tile may be in it twice
  State state_ = State::fresh;
  // The tile is to call itself to a step, by an empty update: to its first step, and to one after a loss.
  bool call_ = false;
  bool imaged_ = false;     // the image on scratch is the tile's present state
  bool handed_ = false;     // the tile was handed over
  bool read_back_ = false;  // what the tile works with comes from scratch
  Inbox inbox_;
  std::uint32_t waiting_hops_ = 0;  // longest chain among waiting updates
  std::uint32_t hops_ = 0;
  std::uint64_t updates_sent_ = 0;
  PeerCounters counters_;
};

}  // namespace tessera
