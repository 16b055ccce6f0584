#include "actors/engine/caller.h"

#include <algorithm>
#include <utility>

namespace tessera {
namespace {

Phase phase_of(RunStage stage) {
  switch (stage) {
    case RunStage::triangulating:
      return Phase::triangulating;
    case RunStage::splaying:
      return Phase::splaying;
    case RunStage::collecting:
      break;
  }
  return Phase::collecting;
}

Phase phase_of(Work work) {
  if (work == Work::begin) return Phase::triangulating;
  return work == Work::collect ? Phase::collecting : Phase::splaying;
}

void show(const RunProgress& from, double opened_s, Progress& to) {
  to.phase = phase_of(from.stage);
  const PartProgress& sum = from.sum;
  to.points_triangulated = sum.points_begun;
  to.tiles_triangulated = static_cast<std::uint32_t>(sum.tiles_begun);
  to.tiles_stored = static_cast<std::uint32_t>(sum.tiles_stored);
  to.tiles_asleep = static_cast<std::uint32_t>(sum.tiles_asleep);
  to.updates_sent = sum.updates_sent;
  to.updates_processed = sum.updates_processed;
  to.points_sent = sum.points_sent;
  to.memory_bytes = sum.memory_bytes;
  to.bytes_between = sum.gates.bytes;
  to.credit_waits = sum.gates.waits;
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

void RunCaller::stored(const TileDone& tile) {
  done_.push_back(tile);
  progress_.map.reached(tile.entry.tile, TileStage::stored);
}

void RunCaller::ended(RunEnded end) noexcept {
  const auto told = end_;  // whoever waits may be gone before this returns
  told->set_value(std::move(end));
}

RunSummary RunCaller::summary(const RunEnded& ended) {
  std::sort(done_.begin(), done_.end(),
            [](const TileDone& a, const TileDone& b) { return a.entry.tile < b.entry.tile; });
  RunSummary summary;
  for (const TileDone& tile : done_) {
    summary.tiles.push_back(tile.entry);
    summary.tile_seconds.push_back(seconds(tile.microseconds));
    summary.vertices += tile.entry.own_points;
    summary.cells += tile.entry.main_cells;
  }
  summary.exchange.points = ended.sum.points;
  summary.exchange.updates = ended.sum.updates;
  summary.exchange.hops = ended.sum.hops;
  summary.exchange.most_received = ended.sum.most_received;
  summary.memory_bytes = ended.memory_bytes;
  summary.exchange.nodes = ended.nodes;
  summary.exchange.nodes_lost = ended.nodes_lost;
  summary.exchange.tiles_again = ended.tiles_again;
  summary.exchange.bytes_between = ended.sum.gates.bytes;
  summary.exchange.credit_waits = ended.sum.gates.waits;
  summary.exchange.sleeps = ended.sum.sleeps;
  summary.exchange.work = {seconds(ended.sum.begin_us), seconds(ended.sum.splay_us), seconds(ended.sum.collect_us)};
  summary.exchange.waves = ended.waves;
  summary.wall = {seconds(ended.triangulate_us), seconds(ended.splay_us), seconds(ended.collect_us)};
  return summary;
}

}  // namespace tessera
