// Decides which tile of a job works next on a node, within the job's share of memory and threads. A plain object
// without I/O and threads: it is told what has happened, and says what to do. Each call takes time in the logarithm of
// the number of tiles, except enter() and release().
//
// mode       | permits that are given
// exchanging | begin, to every tile in order; step, to tiles in memory: first those with the shortest chain of mail
//            | behind them, of these those with most mail. Such steps come once all tiles have begun, or earlier when
//            | the next tile to begin would need another tile to sleep. Then step, to sleeping tiles, in one sweep
//            | after the other along the order of tiles and back, because tiles that are near in this order are near
//            | in space, too. Where room is needed, sleep: to tiles without mail, the farthest from the sweep first
// settling   | settle, to the tiles in memory, and with settle_asleep to those asleep, too
// handing    | hand over, to all tiles that have begun: the node leaves
// collecting | finish, to all tiles that are not stored, those in memory first; drop, to the others; sleep as above
// suspending | sleep, to tiles in memory, up to suspend_bytes. The other tiles are given up: what they began from, or
//            | an earlier image, is still there
// stopping   | none
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
  // Threads of the node. At most twice as many permits are out, so that a thread that is done finds the next work
  // waiting. The permits beyond `threads` are for small work only, which takes less time than asking for more.
  std::uint32_t threads = 1;
  std::uint64_t memory_bytes = 0;  // for tiles in memory, their mail and what is being stored
  // What a tile needs, in bytes for each unit of weight: while it begins, and on top of what it holds while it is
  // collected.
  std::uint64_t begin_bytes = 0, collect_bytes = 0;
  double mail_growth = 0;  // by how many bytes a tile grows for each byte of mail that it takes in
  // Bound for the tiles that leave images when the run is suspended, together: some tenths of a second of writing.
  std::uint64_t suspend_bytes = std::uint64_t{256} << 20;
  // What a tile takes beside what it holds, in percent of what it holds while awake: while it falls asleep, and while
  // its image is read.
  std::uint64_t sleep_percent = 120, wake_percent = 200;
  // A tile that holds fewer bytes was not built when it began, and is built at its first mail. That step needs as much
  // memory as a beginning. Such a tile never sleeps, as it has nothing to free. 0: there are no such tiles.
  std::uint64_t unbuilt_bytes = 0;
  bool settle_asleep = false;  // later readers cannot use images: settle sleeping tiles, too
};

class Schedule {
 public:
  enum class Mode : std::uint8_t { exchanging, settling, collecting, handing, suspending, stopping };
  // The leave for a tile to do one piece of work.
  struct Permit {
    TileId tile;
    Work work;
  };

  // `weights` is by tile. A weight of 0 means that there is no such tile, or that it is on another node; such tiles are
  // not kept.
  Schedule(const ScheduleOptions& options, const std::vector<std::uint64_t>& weights);

  // Notes that the result of a tile is stored already. The tile takes part in the exchange and is not collected. Does
  // nothing when the tile is not here.
  void set_stored(TileId tile);
  // Adds a fresh tile that has come to this node. REQUIRES: no tile of this number is here, and the mode is not
  // settling.
  void add(TileId tile, std::uint64_t weight);
  // Removes and returns fresh tiles that do not work and are not stored, the last first, until they weigh `weight`
  // together or there are no more.
  std::vector<TileId> release(std::uint64_t weight);
  // REQUIRES: modes go forward only, in the order of Mode, or back from settling to exchanging. A schedule enters
  // handing from exchanging.
  void enter(Mode mode);
  Mode mode() const { return mode_; }

  // The mail that waits for a tile, and the memory that it takes.
  struct Waiting {
    std::uint64_t updates = 0, bytes = 0, memory = 0;
    std::uint32_t hops = 0;  // length of the longest chain of updates that ends with one of these
  };
  // Says what waits for a tile now, after more mail has come. Ignored while the tile works, because its report will say
  // it.
  void note_mail(TileId tile, const Waiting& waiting);
  // A tile has done the work of its permit. `bytes` is what it holds beside its mail, `storing` what it has given to
  // the store.
  void note_done(TileId tile, Work work, std::uint64_t bytes, const Waiting& waiting, std::uint64_t storing = 0);
  // What the tile has given to the store is stored.
  void note_stored(TileId tile);
  // Gives a tile up, if it is here: no work, report or mail of it is expected any more.
  void abandon(TileId tile);

  // Returns the next permit, if one can be given now. The tile counts as working until note_done().
  std::optional<Permit> next();

  bool all_begun() const { return fresh_ == 0; }
  // Returns whether no permit is out, nothing is being stored, and nothing waits for which this mode would give a
  // permit.
  bool idle() const;
  bool working(TileId tile) const {
    const auto found = tiles_.find(tile);
    return found != tiles_.end() && found->second.working;
  }
  bool storing(TileId tile) const {
    const auto found = tiles_.find(tile);
    return found != tiles_.end() && found->second.residency == Residency::storing;
  }
  std::uint64_t memory() const { return memory_; }
  std::uint32_t asleep() const { return asleep_; }
  std::uint64_t sleeps() const { return sleeps_; }

 private:
  enum class Residency : std::uint8_t { fresh, awake, asleep, storing, gone };
  struct Tile {
    std::uint64_t weight = 0;
    Waiting mail;
    std::uint64_t memory =
        0;  // reserved while it works, reported after that; includes its mail and what is being stored
    std::uint64_t storing = 0;
    std::uint64_t held = 0;  // beside mail, when it was last awake
    Residency residency = Residency::gone;
    bool working = false, is_stored = false, settled = false;
    bool falling_asleep = false;  // while it works
  };
  using Ready = std::tuple<std::uint32_t, std::uint64_t, TileId>;  // order of steps: the greatest is first
  using Rank = std::pair<std::uint64_t, TileId>;                   // bytes of mail, tile

  // Take a tile out of the sets in which it is, and put it into those in which it belongs now.
  void unlink(TileId tile);
  void link(TileId tile);
  static Ready rank(TileId id, const Tile& tile);
  bool pending(const Tile& tile) const;
  // Returns whether the tile can have `needed` bytes once others have given `freed` bytes back.
  bool fits(TileId tile, std::uint64_t needed, std::uint64_t freed = 0) const;
  std::optional<Permit> step_awake();
  std::optional<Permit> hand_next();
  std::optional<Permit> wake_next();
  std::optional<TileId> next_of_sweep();
  std::optional<TileId> to_sleep(TileId but) const;
  // How many bytes the tile may take at most on top of what it holds, in a step.
  std::uint64_t growth(const Tile& tile) const;
  // Whether the tile has begun and holds nothing yet.
  bool unbuilt(const Tile& tile) const;
  std::uint64_t sleeping_bytes(const Tile& tile) const { return tile.held * options_.sleep_percent / 100; }
  std::uint64_t waking_bytes(const Tile& tile) const { return tile.held * options_.wake_percent / 100; }
  bool ahead() const { return working_ >= options_.threads; }
  void set_memory(Tile& tile, std::uint64_t bytes);
  std::optional<Permit> permit(TileId tile, Work work, std::uint64_t needed);
  std::optional<Permit> put_to_sleep(TileId tile);
  std::optional<Permit> grant_in_room(TileId tile, Work work, std::uint64_t needed);

  ScheduleOptions options_;
  std::map<TileId, Tile> tiles_;  // only tiles that are here: there may be very many elsewhere
  Mode mode_ = Mode::exchanging;
  std::set<Ready, std::greater<>> ready_;      // in memory, idle, with mail
  std::set<TileId> called_;                    // asleep, with mail
  std::set<TileId> quiet_;                     // in memory, idle, without mail
  std::set<Rank> awake_;                       // in memory, idle, with mail: the least mail first
  std::set<std::pair<bool, TileId>> pending_;  // idle, to be settled, collected or handed over; false: in memory
  TileId sweep_{0};                            // where the sweep is
  bool sweeping_back_ = true;                  // the first sweep begins at the end of the order of tiles
  TileId next_fresh_{0};                       // no idle fresh tile comes before this one
  std::uint32_t fresh_ = 0;                    // not begun, or just beginning
  std::uint32_t working_ = 0, storing_ = 0, asleep_ = 0;
  std::uint64_t memory_ = 0;  // of all tiles
  std::uint64_t storing_bytes_ = 0;
  std::uint64_t freeing_ = 0;  // the part of memory_ of tiles that are falling asleep
  std::uint64_t sleeps_ = 0;
  std::uint64_t suspended_bytes_ = 0;
};

}  // namespace tessera
