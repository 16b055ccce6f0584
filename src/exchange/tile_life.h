// One tile's life between messages, whatever its program does. Not thread-safe: one actor owns it.
//
//   fresh -- begin --> awake -- sleep --> asleep
//                      awake <-- (step or finish wakes it) -- asleep
//                      awake, asleep, fresh -- finish --> gone
//                      awake, asleep -- drop, hand_over --> gone
// Mail may come in any state but gone, and waits until step(); what comes for a tile that was handed over is dropped.
// A fresh tile is finished when the run was settled before: what it has settled is then all it needs (docs/design.md,
// section 3).
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "src/base/result.h"
#include "src/exchange/counters.h"
#include "src/exchange/mail.h"
#include "src/exchange/routing_table.h"
#include "src/exchange/tile_program.h"
#include "src/exchange/tile_storage.h"
#include "src/exchange/update.h"

namespace tessera {

// Hears of every update: the harness checks that nothing is believed quiet that is not.
class ExchangeWatch {
 public:
  virtual ~ExchangeWatch() = default;
  // `now`: of the tile that has sent, has processed, or has a new table.
  virtual void sent(TileIncarnation from, TileIncarnation to, Totals now) = 0;
  virtual void processed(TileIncarnation from, TileIncarnation to, Totals now) = 0;
  virtual void rejoined(TileIncarnation self, Totals now) = 0;
};

// What all tiles of a job on one node have in common in a stage, read-only.
struct TileContext {
  std::shared_ptr<const TilePrograms> programs;
  bool many_nodes = false;                           // images are no use to those who come after: everybody settles
  std::uint64_t mail_bytes_max = ~std::uint64_t{0};  // that a tile keeps in memory
  TileStorage* storage = nullptr;
  ExchangeWatch* watch = nullptr;
};

class TileLife {
 public:
  // `table`: by which it begins.
  TileLife(TileIncarnation self, const TileContext& context, std::shared_ptr<const RoutingTable> table);

  // From the image that an earlier process has left, or another node has handed over, if there is a sound one, else
  // from what the stage before has left.
  Status begin();
  // Drops what a dead tile sent, or what was sent to an earlier life of this one.
  Status receive(Update update);
  // Tiles were reborn: from now on nothing from their dead incarnations counts, and if this tile has begun, it calls
  // itself to a step (take_outgoing()), in which it first tells again what may have been lost. In any phase, and at
  // once: neither the program nor scratch is touched. A table that is no newer than the tile's changes nothing.
  // `rebirths`: up to this table, since the tile's, or earlier; null: it has not begun.
  void rejoin(std::shared_ptr<const RoutingTable> table, const IncarnationChanges* rebirths);
  // Processes all mail that waits. No update is counted as processed before the program has worked on it.
  Status step();
  // Leaves an image on scratch, from which the tile also begins in a resumed run.
  Status sleep();
  // Leaves an image where other nodes find it: as another incarnation the tile goes on from it elsewhere. What has
  // come, and was not processed, others tell it again. Whatever happens, the tile is gone.
  Status hand_over();
  // After quiescence: writes down what finish() of a fresh tile needs, if no image says it.
  Status settle();
  // The end of the stage. The tile has no program any more.
  Result<std::unique_ptr<Finished>> finish();
  // Removes what waits on scratch: as another incarnation the tile may come back to this node. REQUIRES: it is fresh.
  Status leave();
  // Frees the memory of a tile that need not be finished.
  void drop();

  // Updates the others must get, by now counted as sent.
  std::vector<Update> take_outgoing();

  std::uint64_t waiting_updates() const { return mail_.updates(); }
  std::uint64_t waiting_bytes() const { return mail_.bytes(); }
  std::uint32_t waiting_hops() const { return waiting_hops_; }  // the longest chain that ends with a waiting update
  std::uint64_t mail_memory() const { return mail_.memory(); }
  Totals totals() const { return counters_.totals(); }
  std::uint64_t updates_sent() const { return updates_sent_; }
  std::size_t memory() const { return program_->memory() + mail_.memory() + counters_.memory(); }
  const ExchangeCounts& counts() const { return program_->counts(); }
  std::uint32_t hops() const { return hops_; }  // the longest chain of updates that reached this tile

 private:
  enum class Phase : std::uint8_t { fresh, awake, asleep, gone };

  // What `work` gives; but an error when what was read from scratch, sound by its checksums, cannot be worked with. No
  // tile begins from that again.
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
  std::vector<TileId> reborn_;  // since its last step, some perhaps twice
  Phase phase_ = Phase::fresh;
  bool call_ = false;       // itself to a step, by mail: to its first, and to one after a loss
  bool imaged_ = false;     // the image on scratch is the tile's present state
  bool handed_ = false;     // the tile has been handed over
  bool read_back_ = false;  // what it works with comes from scratch
  Mail mail_;
  std::uint32_t waiting_hops_ = 0;  // longest chain among waiting updates
  std::uint32_t hops_ = 0;
  std::uint64_t updates_sent_ = 0;
  PeerCounters counters_;
};

}  // namespace tessera
