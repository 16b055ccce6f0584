// A node: owns the memory budget of one process, decides which tile works next, and speaks for its tiles.
//
// state      | message      | effect
// waiting    | Start        | grant work: first every tile is triangulated, then those with most mail splay
// exchanging | MailNotice   | remember, grant if a thread is free
// exchanging | TileReport   | note the tile's counters, grant the next; tell the coordinator when all is idle
// exchanging | Probe        | answer with the sums of all tiles; idle only if no grant is out and no mail is known
// exchanging | CollectAll   | grant collect to every tile
// collecting | TileReport   | grant the next, if not too many wait to be stored
// collecting | TileStored   | grant the next; NodeFinished when every tile is stored
// any        | failed TileReport | grant nothing more; NodeFailed once nothing is under way
//
// A tile's counters change only while it works under a grant, and every grant ends in a report. So when no grant is out
// the node's copies are exact: its answer to a probe is a true snapshot of all its tiles.
#pragma once

#include <caf/all.hpp>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <vector>

#include "actors/protocol.h"
#include "actors/run_log.h"
#include "actors/tile_actor.h"

namespace tessera {

struct NodeOptions {
  std::uint32_t node = 0;
  std::uint32_t threads = 1;       // grants under way at most
  std::uint64_t memory_bytes = 0;  // for tiles in memory
  // What a tile needs, in bytes a point: while it is triangulated, and on top of what it holds while it is collected.
  std::uint64_t triangulate_bytes = 0, collect_bytes = 0;
  std::vector<std::uint64_t> points;  // by tile; 0 = no such tile
  std::vector<TileEntry> stored;  // tiles whose result a resumed run has already: they exchange, but are not written
  std::stop_token stop;
};

class NodeActor : public caf::event_based_actor {
 public:
  NodeActor(caf::actor_config& config, const NodeOptions& options, const Directory& directory, RunLog& log,
            caf::actor coordinator, Progress* progress);
  caf::behavior make_behavior() override;
  void on_exit() override;

 private:
  enum class Stage : std::uint8_t { fresh, awake, asleep, storing, stored };
  struct Tile {
    Stage stage = Stage::fresh;
    bool working = false;
    std::uint64_t mail = 0;    // points known to wait
    std::uint64_t memory = 0;  // reserved while it works, reported after
    Totals totals;
  };

  void dispatch();
  bool grant_one();
  bool try_grant(std::uint32_t tile, Work work, std::uint64_t needed);
  void grant(std::uint32_t tile, Work work, std::uint64_t needed);
  std::optional<std::uint32_t> sleeper() const;
  void finish(const TileReport& report);
  void finish(const TileStored& stored);
  void fail(std::uint8_t code, const std::string& text);
  bool idle() const;
  void report_progress();

  const NodeOptions options_;
  const Directory& directory_;
  RunLog& log_;
  caf::actor coordinator_;
  Progress* progress_;
  std::vector<Tile> tiles_;
  std::chrono::steady_clock::time_point begin_;
  bool started_ = false, collecting_ = false;
  std::uint32_t working_ = 0;                        // grants under way
  std::uint32_t storing_ = 0;                        // meshes on their way to the store, beside these
  std::uint32_t next_fresh_ = 0, next_collect_ = 0;  // no fresh tile, none to be collected, comes before
  std::uint64_t memory_ = 0;                         // sum over tiles
  std::optional<Error> failure_;
  bool ended_ = false;
};

}  // namespace tessera
