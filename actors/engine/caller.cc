#include "actors/engine/caller.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

namespace tessera {
namespace {

Phase phase_of(RunStep step) {
  switch (step) {
    case RunStep::beginning:
      return phase_of(ProgramKind::delaunay, StageStep::begin);
    case RunStep::exchanging:
      return phase_of(ProgramKind::delaunay, StageStep::exchange);
    case RunStep::ending:
      break;
  }
  return phase_of(ProgramKind::delaunay, StageStep::store);
}

Phase phase_of(Work work) {
  if (work == Work::begin) return phase_of(RunStep::beginning);
  return phase_of(work == Work::finish ? RunStep::ending : RunStep::exchanging);
}

void show(const RunProgress& from, double opened_s, Progress& to) {
  to.phase = phase_of(from.step);
  const ShareProgress& sum = from.sum;
  to.points_triangulated = sum.weight_begun;
  to.tiles_triangulated = static_cast<std::uint32_t>(sum.tiles_begun);
  to.tiles_stored = static_cast<std::uint32_t>(sum.tiles_stored);
  to.tiles_asleep = static_cast<std::uint32_t>(sum.tiles_asleep);
  to.updates_sent = sum.updates_sent;
  to.updates_processed = sum.updates_processed;
  to.points_sent = sum.items_sent;
  to.memory_bytes = sum.memory_bytes;
  to.bytes_between = sum.outboxes.bytes;
  to.credit_waits = sum.outboxes.waits;
  to.nodes_lost = from.nodes_lost;
  to.set_nodes(from.nodes);
  to.mail.add(sum.mail);
  for (const WorkSpan& span : sum.spans) {
    to.add_span({phase_of(span.work), span.tile, span.thread, opened_s + static_cast<double>(span.begin_us) * 1e-6,
                 opened_s + static_cast<double>(span.end_us) * 1e-6});
  }
}

double seconds(std::uint64_t microseconds) { return static_cast<double>(microseconds) * 1e-6; }

}  // namespace

void RunCaller::progressed(const RunProgress& now) { show(now, opened_s_, progress_); }

void RunCaller::stored(const TileDone& done) {
  const auto entry = tile_entry_of(done.tile.receipt);
  if (!entry || entry->tile != done.tile.tile) {
    throw std::runtime_error("tile " + std::to_string(done.tile.tile.value) +
                             ": a node sent an entry for it that cannot be read");
  }
  done_.push_back({*entry, done.microseconds});
  progress_.map.note_reached(entry->tile, TileStatus::stored);
}

void RunCaller::ended(RunEnded end) noexcept {
  const auto told = end_;  // the waiting thread may destroy this object before this returns
  told->set_value(std::move(end));
}

RunSummary RunCaller::summary(const RunEnded& ended) {
  std::sort(done_.begin(), done_.end(), [](const Stored& a, const Stored& b) { return a.entry.tile < b.entry.tile; });
  RunSummary summary;
  for (const Stored& tile : done_) {
    summary.tiles.push_back(tile.entry);
    summary.tile_seconds.push_back(seconds(tile.microseconds));
    summary.vertices += tile.entry.own_points;
    summary.cells += tile.entry.main_cells;
  }
  summary.exchange.points = ended.sum.items;
  summary.exchange.updates = ended.sum.updates;
  summary.exchange.hops = ended.sum.hops;
  summary.exchange.most_received = ended.sum.most_received;
  summary.memory_bytes = ended.memory_bytes;
  summary.exchange.nodes = ended.nodes;
  summary.exchange.nodes_lost = ended.nodes_lost;
  summary.exchange.tiles_again = ended.tiles_again;
  summary.exchange.bytes_between = ended.sum.outboxes.bytes;
  summary.exchange.credit_waits = ended.sum.outboxes.waits;
  summary.exchange.sleeps = ended.sum.sleeps;
  summary.exchange.work = {seconds(ended.sum.begin_us), seconds(ended.sum.exchange_us), seconds(ended.sum.collect_us)};
  summary.exchange.waves = ended.waves;
  const StageTimes& times = ended.stages.at(0);
  summary.wall = {seconds(times.begin_us), seconds(times.exchange_us), seconds(times.end_us)};
  return summary;
}

}  // namespace tessera
