// What a share has done so far, as its tiles tell it: its progress while it works, and sums at its end. A plain object
// without actors and clock: it is told the time. Not thread-safe.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "actors/node_meter.h"
#include "actors/protocol.h"
#include "src/base/mail_arcs.h"

namespace tessera {

class ShareAccount {
 public:
  using Time = std::chrono::steady_clock::time_point;
  // What one tile has told last.
  struct Tile {
    Totals totals;
    ExchangeCounts items;
    std::uint64_t updates = 0, microseconds = 0;
  };

  // `interval` is the shortest time between two messages of progress. It grows with the number of nodes when they are
  // many. `stored_before` is the number of tiles that an earlier process has stored.
  ShareAccount(NodeId self, std::chrono::milliseconds interval, std::size_t stored_before, Time now);

  // The counters of all tiles, which a tally has.
  const Totals& totals() const { return totals_; }
  // A tile tells its counters. note(tile, {}): the tile has left, and its counters with it.
  void note(Tile& tile, Totals totals);
  // A tile tells what it has done under a permit, also when that has failed.
  void note(Tile& tile, const TileReport& report);
  void tile_has_begun(std::uint64_t weight);
  void tile_is_stored() { ++progress_.tiles_stored; }
  // `kept`: an image was left for another node.
  void tile_is_handed_over(bool kept) { ++(kept ? sum_.handed : sum_.not_handed); }

  // The share begins the stage of its first table.
  void begin(std::size_t stored_before) { progress_.tiles_stored = stored_before; }
  // The next stage begins. `stored_before` and `sleeps` are of the stage that is over.
  void begin_next_stage(std::size_t stored_before, std::uint64_t sleeps);

  // Returns whether progress is to be told now: because `at_once` says so, because the interval has passed, or because
  // there are many spans. The interval then begins anew.
  bool is_due(Time now, bool at_once, std::size_t nodes);
  // Returns the progress of the present stage, with what is true at this moment.
  const ShareProgress& progress(std::uint32_t asleep, std::uint64_t memory_bytes, const OutboxCounts& outboxes);
  // Returns the same for the meter of the node, over all stages. `stored_before` is of the present stage.
  NodeWork work(std::size_t stored_before, std::uint64_t waiting_bytes) const;
  void set_mail(std::vector<MailArc> mail) { progress_.mail = std::move(mail); }
  // The spans were told.
  void forget_spans() { std::vector<WorkSpan>().swap(progress_.spans); }

  // Adds what is known at the end alone.
  void end(std::uint64_t sleeps, const OutboxCounts& outboxes);
  // The sums, as the last message of the share has them.
  ShareEnded& sum() { return sum_; }

 private:
  Totals totals_;
  ShareEnded sum_;
  ShareProgress progress_;  // of the present stage
  NodeWork before_;         // work done in earlier stages
  std::chrono::milliseconds interval_;
  Time told_;
};

}  // namespace tessera
