#include "actors/share_account.h"

#include <algorithm>
#include <utility>

namespace tessera {
namespace {

// Many small tiles make many spans in a moment. The spans are sent before they take more memory than the tiles.
constexpr std::size_t spans_max = 1000;
// Up to so many nodes send progress at the shortest interval. With more nodes each waits longer, so that the
// coordinator has no more to do.
constexpr std::size_t nodes_at_once = 50;

}  // namespace

ShareAccount::ShareAccount(NodeId self, std::chrono::milliseconds interval, std::size_t stored_before, Time now)
    : interval_(interval), told_(now) {
  sum_.node = progress_.node = self;
  progress_.tiles_stored = stored_before;
}

void ShareAccount::note(Tile& tile, Totals totals) {
  Totals& before = tile.totals;
  totals_.sent += totals.sent - before.sent;
  totals_.processed += totals.processed - before.processed;
  before = totals;
}

void ShareAccount::note(Tile& tile, const TileReport& report) {
  const WorkSpan& span = report.span;
  note(tile, Totals{report.sent, report.processed});
  sum_.updates += report.updates - tile.updates;
  tile.updates = report.updates;
  sum_.items += report.items;
  sum_.items -= tile.items;
  tile.items = report.items;
  sum_.hops = std::max<std::uint64_t>(sum_.hops, report.hops);
  sum_.most_received = std::max(sum_.most_received, report.items.received);
  const std::uint64_t us = span.end_us - span.begin_us;
  tile.microseconds += us;
  (span.work == Work::begin ? sum_.begin_us : span.work == Work::finish ? sum_.collect_us : sum_.exchange_us) += us;
  progress_.spans.push_back(span);
}

void ShareAccount::tile_has_begun(std::uint64_t weight) {
  ++progress_.tiles_begun;
  progress_.weight_begun += weight;
}

void ShareAccount::begin_next_stage(std::size_t stored_before, std::uint64_t sleeps) {
  before_.tiles_begun += progress_.tiles_begun;
  before_.weight_begun += progress_.weight_begun;
  before_.tiles_stored += progress_.tiles_stored - stored_before;
  progress_.tiles_begun = progress_.weight_begun = progress_.tiles_stored = 0;
  sum_.sleeps += sleeps;
  totals_ = {};
}

bool ShareAccount::is_due(Time now, bool at_once, std::size_t nodes) {
  const bool due = at_once || progress_.spans.size() >= spans_max ||
                   now - told_ >= interval_ * std::max<std::size_t>(1, nodes / nodes_at_once);
  if (due) told_ = now;
  return due;
}

const ShareProgress& ShareAccount::progress(std::uint32_t asleep, std::uint64_t memory_bytes,
                                            const OutboxCounts& outboxes) {
  progress_.tiles_asleep = asleep;
  progress_.updates_sent = totals_.sent;
  progress_.updates_processed = totals_.processed;
  progress_.items_sent = sum_.items.sent;
  progress_.memory_bytes = memory_bytes;
  progress_.outboxes = outboxes;
  return progress_;
}

NodeWork ShareAccount::work(std::size_t stored_before, std::uint64_t waiting_bytes) const {
  return {0,
          progress_.tiles_asleep,
          progress_.memory_bytes,
          waiting_bytes,
          before_.tiles_begun + progress_.tiles_begun,
          before_.weight_begun + progress_.weight_begun,
          before_.tiles_stored + progress_.tiles_stored - stored_before,
          progress_.outboxes};
}

void ShareAccount::end(std::uint64_t sleeps, const OutboxCounts& outboxes) {
  sum_.sleeps += sleeps;
  sum_.outboxes += outboxes;
}

}  // namespace tessera
