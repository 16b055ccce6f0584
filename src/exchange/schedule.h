// Which tile of a job works next on a node, within the job's share of memory and threads. Pure: told what has happened,
// it says what to do. Every step takes time in the logarithm of the number of tiles.
//
// phase      | what is granted
// exchanging | begin to every tile, in their order; step in memory, first those with the shortest chain of mail behind
//            | them, of these those with most mail: once all have begun, or before the next begins where that needs
//            | another to sleep. Then step those asleep, in one sweep after the other along the order of the tiles and
//            | back, for what is near is near in that order, too; sleep where room is needed: those without mail, the
//            | farthest from the sweep first
// settling   | settle to the tiles in memory
// handing    | hand over to all that have begun: the node leaves
// collecting | finish to all that are not stored, those in memory first; drop to the others; sleep as above
// suspending | sleep to tiles in memory, up to suspend_bytes; the others are given up: what they began from, or an
//            | earlier image, is still there
// stopping   | nothing
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "src/base/ids.h"
#include "src/exchange/work.h"

namespace tessera {

struct ScheduleOptions {
  // Of the node. Twice as many grants are under way at most: a thread that is done finds the next one waiting, unless
  // that is a large one, rather than waits for it. Small work takes less time than asking for more.
  std::uint32_t threads = 1;
  std::uint64_t memory_bytes = 0;  // for tiles in memory, their mail and what is being stored
  // What a tile needs, in bytes a unit of weight: while it begins; on top of what it holds while it is collected.
  std::uint64_t begin_bytes = 0, collect_bytes = 0;
  double mail_growth = 0;  // bytes that a tile holds more for each byte of mail that it takes in
  // Held by all tiles together that leave images when the run is suspended: some tenths of a second.
  std::uint64_t suspend_bytes = std::uint64_t{256} << 20;
  // In percent of what a tile holds while it is awake, what it takes beside that while it falls asleep, and while its
  // image is read.
  std::uint64_t sleep_percent = 120, wake_percent = 200;
  bool settle_asleep = false;  // images are no use to those who come after: settle the tiles asleep, too
};

class Schedule {
 public:
  enum class Phase : std::uint8_t { exchanging, settling, collecting, handing, suspending, stopping };
  struct Permit {
    TileId tile;
    Work work;
  };

  // `weights` by tile: 0 where there is no tile, or where it is another node's. Those are not kept.
  Schedule(const ScheduleOptions& options, const std::vector<std::uint64_t>& weights);

  // A tile whose result is in the store already, if it is here: it takes part in the exchange, and is not collected.
  void set_stored(TileId tile);
  // A tile that has come here: fresh. REQUIRES: there is none of its number here, and more are granted.
  void add(TileId tile, std::uint64_t weight);
  // Fresh tiles that nobody works on, the last first, until they have `weight` in all or there are no more: they are
  // not here any longer.
  std::vector<TileId> release(std::uint64_t weight);
  // REQUIRES: only forward, in the order of Phase; or back from settling to exchanging. Handing over follows
  // exchanging.
  void enter(Phase phase);
  Phase phase() const { return phase_; }

  // Mail that waits for a tile, and the memory it takes.
  struct Waiting {
    std::uint64_t updates = 0, bytes = 0, memory = 0;
    std::uint32_t hops = 0;  // of the longest chain of updates that ends with one of these
  };
  // What waits now, since more has come. Ignored while the tile works: its report will tell.
  void mail(TileId tile, const Waiting& waiting);
  // The work granted is done. `bytes`: what the tile holds beside its mail. `storing`: what it has given to the store.
  void done(TileId tile, Work work, std::uint64_t bytes, const Waiting& waiting, std::uint64_t storing = 0);
  void stored(TileId tile);
  // Nothing more is to be expected of a tile, if it is here.
  void abandon(TileId tile);

  // What to grant now, if anything: the tile counts as working until done().
  std::optional<Permit> next();

  bool all_begun() const { return fresh_ == 0; }
  // Nothing is under way and nothing waits that this phase would grant.
  bool idle() const;
  bool working(TileId tile) const {
    const auto found = tiles_.find(tile);
    return found != tiles_.end() && found->second.working;
  }
  bool storing(TileId tile) const {
    const auto found = tiles_.find(tile);
    return found != tiles_.end() && found->second.place == Place::storing;
  }
  std::uint64_t memory() const { return memory_; }
  std::uint32_t asleep() const { return asleep_; }
  std::uint64_t sleeps() const { return sleeps_; }

 private:
  enum class Place : std::uint8_t { fresh, awake, asleep, storing, gone };
  struct Tile {
    std::uint64_t weight = 0;
    Waiting mail;
    std::uint64_t memory = 0;  // reserved while it works, reported after; its mail and what is being stored included
    std::uint64_t storing = 0;
    std::uint64_t held = 0;  // beside mail, when it was last awake
    Place place = Place::gone;
    bool working = false, is_stored = false, settled = false;
  };
  using Ready = std::tuple<std::uint32_t, std::uint64_t, TileId>;  // the greatest works first
  using Rank = std::pair<std::uint64_t, TileId>;                   // bytes of mail, tile

  // Takes a tile out of the sets it is in, or puts it where it belongs now.
  void unlink(TileId tile);
  void link(TileId tile);
  static Ready place(TileId id, const Tile& tile);
  bool pending(const Tile& tile) const;
  // Whether it can have so much once others have given some back.
  bool fits(TileId tile, std::uint64_t needed, std::uint64_t freed = 0) const;
  std::optional<Permit> step_awake();
  std::optional<Permit> hand_next();
  std::optional<Permit> wake_next();
  std::optional<TileId> next_of_sweep();
  std::optional<TileId> to_sleep(TileId but) const;
  std::uint64_t growth(const Waiting& mail) const;
  std::uint64_t sleeping_bytes(const Tile& tile) const { return tile.held * options_.sleep_percent / 100; }
  std::uint64_t waking_bytes(const Tile& tile) const { return tile.held * options_.wake_percent / 100; }
  bool ahead() const { return working_ >= options_.threads; }
  void set_memory(Tile& tile, std::uint64_t bytes);
  std::optional<Permit> permit(TileId tile, Work work, std::uint64_t needed);
  std::optional<Permit> put_to_sleep(TileId tile);
  std::optional<Permit> grant_in_room(TileId tile, Work work, std::uint64_t needed);

  ScheduleOptions options_;
  std::map<TileId, Tile> tiles_;  // here: there may be very many elsewhere
  Phase phase_ = Phase::exchanging;
  std::set<Ready, std::greater<>> ready_;      // in memory, idle, with mail
  std::set<TileId> called_;                    // asleep, with mail
  std::set<TileId> quiet_;                     // in memory, idle, without mail
  std::set<Rank> awake_;                       // in memory, idle, with mail: the least first
  std::set<std::pair<bool, TileId>> pending_;  // idle, to be settled, collected or handed over; false: in memory
  TileId sweep_{0};                            // where the sweep is
  bool sweeping_back_ = true;                  // at the end of the tiles' order the first one begins
  TileId next_fresh_{0};                       // no idle fresh tile comes before
  std::uint32_t fresh_ = 0;                    // not begun, or just beginning
  std::uint32_t working_ = 0, storing_ = 0, asleep_ = 0;
  std::uint64_t memory_ = 0;  // over all tiles
  std::uint64_t storing_bytes_ = 0;
  std::uint64_t freeing_ = 0;  // of it, what tiles that are falling asleep will give back
  std::uint64_t sleeps_ = 0;
  std::uint64_t suspended_bytes_ = 0;
};

}  // namespace tessera
