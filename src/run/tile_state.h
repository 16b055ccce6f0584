// One tile's life between messages. Not thread-safe: one actor owns it.
//
//   fresh -- begin --> awake -- sleep --> asleep
//                      awake <-- (splay or collect wakes it) -- asleep
//                      awake, asleep, fresh -- collect --> gone
//                      awake, asleep -- drop, hand_over --> gone
// Mail may come in any state but gone, and waits until splay(); what comes for a tile that was handed over is dropped.
// A fresh tile is collected when the run was settled before: its points and its foreign vertices are then all it needs
// (docs/design.md, section 3).
#pragma once

#include <cstddef>
#include <cstdint>
#include <future>
#include <memory>
#include <span>
#include <stop_token>
#include <vector>

#include "src/base/big_vector.h"
#include "src/base/result.h"
#include "src/quiescence/counters.h"
#include "src/run/mail.h"
#include "src/run/table.h"
#include "src/run/tile_storage.h"
#include "src/run/update.h"
#include "src/tile/tile_triangulation.h"

namespace tessera {

// Hears of every update: the harness checks that nothing is believed quiet that is not.
class ExchangeWatch {
 public:
  virtual ~ExchangeWatch() = default;
  // `now`: of the tile that has sent, has processed, or has a new table.
  virtual void sent(Peer from, Peer to, Totals now) = 0;
  virtual void processed(Peer from, Peer to, Totals now) = 0;
  virtual void rejoined(Peer self, Totals now) = 0;
};

// What all tiles of a job on one node have in common, read-only.
struct TileContext {
  int dimension = 3;
  KernelKind kernel = KernelKind::flat;
  // Hand out final cells and keep the rest only: a tenth of the memory, a tenth more work.
  bool reduce = false;
  // Tiles of so many points do so in any case, and store as many of them early, before there are others, as are whole
  // units; 0: none does. What they store depends on these two, not on who stores it when.
  std::uint64_t early_points = 0, early_unit = 1;
  // By tile; a tile with the empty box has no final cells, and announces nothing.
  std::shared_ptr<const std::vector<Box>> boxes;
  std::shared_ptr<const Surroundings> around;
  std::shared_ptr<const Table> table = std::make_shared<const Table>();  // that the part was opened with
  bool many_nodes = false;                            // images are no use to those who come after: everybody settles
  std::uint64_t mail_points_max = ~std::uint64_t{0};  // that a tile keeps in memory
  TileStorage* storage = nullptr;
  std::stop_token stop = {};  // once requested, begin(), splay() and collect() soon throw Stopped
  ExchangeWatch* watch = nullptr;
};

class TileState {
 public:
  TileState(Peer self, const TileContext& context);

  // From the image that an earlier process has left, or another node has handed over, if there is a sound one, else
  // from the tile's points.
  Status begin();
  // Drops what a dead tile sent, or what was sent to an earlier life of this one.
  Status receive(Update update);
  // Tiles were reborn: from now on nothing from their dead incarnations counts, and if this tile has begun, it calls
  // itself to a splay (take_outgoing()), in which it first tells again what may have been lost. In any phase, and at
  // once: neither the triangulation nor scratch is touched. A table that is no newer than the tile's changes nothing.
  // `rebirths`: up to this table, since the tile's, or earlier; null: it has not begun.
  void rejoin(std::shared_ptr<const Table> table, const Rebirths* rebirths);
  // Processes all mail that waits. No update is counted as processed before its points are in.
  Status splay();
  // Leaves an image on scratch, from which the tile also begins in a resumed run.
  Status sleep();
  // Leaves an image where other nodes find it, with its list of final cells: as another incarnation the tile goes on
  // from it elsewhere. What has come, and was not processed, others tell it again. Whatever happens, the tile is gone.
  Status hand_over();
  // After quiescence: writes down what collect() of a fresh tile needs, if no image says it.
  Status settle();
  // What is to be stored. The tile has no triangulation any more.
  Result<CollectedTile> collect();
  // Removes what waits on scratch: as another incarnation the tile may come back to this node. REQUIRES: it is fresh.
  Status leave();
  // Frees the memory of a tile that need not be collected.
  void drop();

  // Updates the others must get, by now counted as sent. None is larger than update_points_max.
  std::vector<Update> take_outgoing();

  std::uint64_t waiting_updates() const { return mail_.updates(); }
  std::uint64_t waiting_points() const { return mail_.points(); }
  std::uint32_t waiting_hops() const { return waiting_hops_; }  // the longest chain that ends with a waiting update
  std::uint64_t mail_memory() const { return mail_.memory(); }
  Totals totals() const { return counters_.totals(); }
  std::uint64_t updates_sent() const { return updates_sent_; }
  std::size_t memory() const;
  const ExchangeCounts& counts() const { return counts_; }
  std::uint32_t hops() const { return hops_; }  // the longest chain of updates that reached this tile

 private:
  enum class Phase : std::uint8_t { fresh, awake, asleep, gone };

  // What stands behind the triangulation in an image.
  struct ImageEnd {
    std::uint64_t own_points = 0;
    std::uint64_t finals_sum = 0;  // of the list of final cells that it goes with; 0: of none
  };
  static std::uint64_t sum_of(const KeptFinals& finals);

  // What `work` gives; but an error when what was read from scratch, sound by its checksums, cannot be worked with. No
  // tile begins from that again.
  template <class Work>
  auto with_what_was_read(const Work& work) -> decltype(work());
  Status begin_somehow();
  Status process_mail();
  Result<CollectedTile> collect_all();
  Status build(bool announce);
  Result<bool> restore(bool at_once);
  Result<bool> restore_handed();
  Status go_on_from_image();
  Result<BigVector<std::byte>> image();
  Status write_handed();
  Status build_settled();
  std::unique_ptr<TileTriangulation> load_image(BigVector<std::byte> bytes, ImageEnd& end) const;
  Status wake();
  Status insert(const std::vector<Update>& mail);
  Status keep_finals(FinalCells finals, const LoadedTile& loaded, bool at_once);
  Status put_finals();
  Result<KeptFinals> take_finals();
  Status await_stored();
  bool decode_finals(std::span<const std::byte> bytes);
  Result<bool> restore_finals(std::span<const std::byte> bytes, bool at_once);
  Error damaged(const char* what) const;
  // Its first cells are stored before the others.
  bool early() const { return context_.early_points > 0 && own_points_ >= context_.early_points; }
  bool dead(const Update& update) const { return update.to != self_ || table_->dead(update.from); }
  Update outgoing(Peer to, std::vector<SharedPoint> points);
  TileOptions options() const {
    return {self_.tile,   context_.dimension, context_.kernel, ExchangeRule::introduce, context_.around.get(),
            context_.stop};
  }

  Peer self_;
  const TileContext& context_;
  std::shared_ptr<const Table> table_;
  std::vector<TileId> reborn_;  // since its last splay, some perhaps twice
  Phase phase_ = Phase::fresh;
  std::unique_ptr<TileTriangulation> triangulation_;
  std::unique_ptr<LoadedTile> points_;  // kept while the tile is whole in memory
  std::unique_ptr<KeptFinals> finals_;  // taken out of the triangulation; when they are not here, they are on scratch
  BigVector<std::byte> stored_early_;   // what the storage has said of those that it has already; with finals_
  std::future<TileStorage::StoredEarly> storing_;  // what it will say
  bool call_ = false;                              // itself to a splay, by mail: to its first, and to one after a loss
  bool imaged_ = false;                            // the image on scratch is the tile's present state
  bool earlier_ = false;                           // it is an earlier process's, though
  bool handed_ = false;                            // the tile has been handed over
  bool read_back_ = false;                         // what it works with comes from scratch
  std::uint64_t own_points_ = 0;
  std::uint64_t finals_sum_ = 0;  // of what is, or was, in finals_
  Mail mail_;
  std::uint32_t waiting_hops_ = 0;  // longest chain among waiting updates
  std::uint32_t hops_ = 0;
  std::uint64_t updates_sent_ = 0;
  PeerCounters counters_;
  ExchangeCounts counts_;
};

}  // namespace tessera
