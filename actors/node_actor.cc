#include "actors/node_actor.h"

#include <algorithm>
#include <utility>

namespace tessera {

NodeActor::NodeActor(caf::actor_config& config, const NodeOptions& options, const Directory& directory, RunLog& log,
                     caf::actor coordinator, Progress* progress)
    : caf::event_based_actor(config),
      options_(options),
      directory_(directory),
      log_(log),
      coordinator_(std::move(coordinator)),
      progress_(progress),
      tiles_(options.points.size()) {
  log_.tiles.resize(tiles_.size());
  log_.summary.tile_seconds.resize(tiles_.size(), 0);
  for (std::size_t t = 0; t < tiles_.size(); ++t) {
    if (options_.points[t] == 0) tiles_[t].stage = Stage::stored;  // nobody there
  }
}

// Coordinator and nodes know each other: one that has ended must not keep the others alive.
void NodeActor::on_exit() { coordinator_ = nullptr; }

caf::behavior NodeActor::make_behavior() {
  set_error_handler([](caf::scheduled_actor*, caf::error&) {});
  return {
      [this](const Start&) {
        started_ = true;
        begin_ = std::chrono::steady_clock::now();
        dispatch();
      },
      [this](const MailNotice& notice) {
        tiles_[notice.tile].mail = std::max(tiles_[notice.tile].mail, notice.points);
        dispatch();
      },
      [this](const TileReport& report) {
        finish(report);
        dispatch();
      },
      [this](const TileStored& stored) {
        finish(stored);
        dispatch();
      },
      [this](const Probe& probe) {
        NodeTally tally{options_.node, probe.wave, idle(), 0, 0};
        for (const Tile& t : tiles_) {
          tally.sent += t.totals.sent;
          tally.processed += t.totals.processed;
        }
        directory_.tell([&] {
          return "node: wave " + std::to_string(probe.wave) + (tally.idle ? ": idle" : ": busy") + ", sent " +
                 std::to_string(tally.sent) + ", processed " + std::to_string(tally.processed);
        });
        send(coordinator_, tally);
      },
      [this](const CollectAll&) {
        collecting_ = true;
        if (progress_) progress_->phase = Phase::collecting;
        for (const TileEntry& entry : options_.stored) {
          if (entry.tile >= tiles_.size() || tiles_[entry.tile].stage == Stage::stored) continue;
          tiles_[entry.tile].stage = Stage::stored;
          log_.summary.tiles.push_back(entry);
        }
        dispatch();
      },
  };
}

bool NodeActor::idle() const {
  return started_ && !collecting_ && working_ == 0 && std::all_of(tiles_.begin(), tiles_.end(), [](const Tile& t) {
           return t.stage != Stage::fresh && t.mail == 0;
         });
}

void NodeActor::finish(const TileReport& report) {
  directory_.tell([&] {
    return "node: tile " + std::to_string(report.tile) + " has done " + name_of(report.work) + ": sent " +
           std::to_string(report.sent) + ", processed " + std::to_string(report.processed) + ", points waiting " +
           std::to_string(report.waiting);
  });
  Tile& tile = tiles_[report.tile];
  tile.working = false;
  --working_;
  memory_ -= tile.memory;
  tile.memory = report.memory;
  memory_ += tile.memory;
  tile.mail = report.waiting;
  tile.totals = {report.sent, report.processed};
  auto& figures = log_.tiles[report.tile];
  figures = {report.received, report.inserted, report.kept, report.points_sent, report.sent};
  RunSummary& sum = log_.summary;
  sum.rounds = std::max<std::uint64_t>(sum.rounds, report.hops);
  const double seconds = static_cast<double>(report.microseconds) * 1e-6;
  sum.tile_seconds[report.tile] += seconds;
  if (report.failed != 0) return fail(report.failed, report.failure);
  switch (report.work) {
    case Work::triangulate:
      tile.stage = Stage::awake;
      sum.triangulate_cpu_s += seconds;
      log_.triangulated_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
      sum.vertices += report.own_points;
      for (std::size_t i = 0; i + 1 < report.duplicates.size(); i += 2) {
        sum.duplicates.emplace_back(report.duplicates[i], report.duplicates[i + 1]);
      }
      if (progress_) {
        ++progress_->tiles_triangulated;
        progress_->points_triangulated += options_.points[report.tile];
      }
      break;
    case Work::splay:
      tile.stage = Stage::awake;
      sum.splay_cpu_s += seconds;
      break;
    case Work::sleep:
      tile.stage = Stage::asleep;
      sum.splay_cpu_s += seconds;
      ++sum.sleeps;
      break;
    case Work::collect:
      tile.stage = Stage::storing;
      ++storing_;
      sum.collect_cpu_s += seconds;
      break;
  }
  report_progress();
}

void NodeActor::finish(const TileStored& stored) {
  Tile& tile = tiles_[stored.tile];
  --storing_;
  memory_ -= std::exchange(tile.memory, 0);
  if (stored.failed != 0) return fail(stored.failed, stored.failure);
  tile.stage = Stage::stored;
  log_.summary.tiles.push_back(entry_from_numbers(stored.entry));
  if (progress_) ++progress_->tiles_stored;
  report_progress();
}

// The first failure is the one to tell.
void NodeActor::fail(std::uint8_t code, const std::string& text) {
  if (!failure_) failure_ = error(static_cast<Errc>(code), text);
}

void NodeActor::report_progress() {
  if (!progress_) return;
  progress_->memory_bytes = memory_;
  progress_->tiles_asleep = static_cast<std::uint32_t>(
      std::count_if(tiles_.begin(), tiles_.end(), [](const Tile& t) { return t.stage == Stage::asleep; }));
}

void NodeActor::dispatch() {
  if (!started_ || ended_) return;
  if (!failure_ && options_.stop.stop_requested()) failure_ = error(Errc::interrupted, "interrupted");
  if (failure_) {
    if (working_ + storing_ == 0) {
      ended_ = true;
      send(coordinator_, NodeFailed{options_.node, static_cast<std::uint8_t>(failure_->code), failure_->where});
    }
    return;
  }
  while (working_ < options_.threads && grant_one()) {
  }
  if (collecting_) {
    const bool all = std::all_of(tiles_.begin(), tiles_.end(), [](const Tile& t) { return t.stage == Stage::stored; });
    if (all) {
      ended_ = true;
      send(coordinator_, NodeFinished{options_.node});
    }
  } else if (idle()) {
    send(coordinator_, IdleNotice{options_.node});
  }
}

// One more grant, if there is work and room for it.
bool NodeActor::grant_one() {
  while (next_fresh_ < tiles_.size() && (tiles_[next_fresh_].stage != Stage::fresh || tiles_[next_fresh_].working)) {
    ++next_fresh_;
  }
  if (next_fresh_ < tiles_.size())
    return try_grant(next_fresh_, Work::triangulate, options_.triangulate_bytes * options_.points[next_fresh_]);
  if (collecting_) {
    const auto collected = [&](std::uint32_t t) {
      return tiles_[t].stage == Stage::storing || tiles_[t].stage == Stage::stored;
    };
    while (next_collect_ < tiles_.size() && collected(next_collect_)) ++next_collect_;
    // A tile that falls asleep at this moment is left for later, not out.
    std::uint32_t t = next_collect_;
    while (t < tiles_.size() && (collected(t) || tiles_[t].working)) ++t;
    if (t == tiles_.size() || storing_ > options_.threads) return false;
    return try_grant(t, Work::collect, tiles_[t].memory + options_.collect_bytes * options_.points[t]);
  }
  // The tile with most mail; one in memory counts double, for waking costs time.
  std::optional<std::uint32_t> best;
  std::uint64_t most = 0;
  for (std::uint32_t t = 0; t < tiles_.size(); ++t) {
    const Tile& tile = tiles_[t];
    const std::uint64_t weight = tile.mail * (tile.stage == Stage::awake ? 2 : 1);
    if (!tile.working && weight > most && tile.stage != Stage::fresh) {
      best = t;
      most = weight;
    }
  }
  if (!best) return false;
  const std::uint64_t mail_bytes = tiles_[*best].mail * 1000;  // each foreign point may become a vertex
  const bool wake = tiles_[*best].stage == Stage::asleep;
  const std::uint64_t asleep = wake ? options_.triangulate_bytes * options_.points[*best] / 6 : 0;
  return try_grant(*best, Work::splay, tiles_[*best].memory + asleep + mail_bytes);
}

// Grants, or makes room by putting another tile to sleep, or leaves it for when something ends. Something is always
// under way: with nothing else in memory a tile may exceed the budget.
bool NodeActor::try_grant(std::uint32_t tile, Work work, std::uint64_t needed) {
  const std::uint64_t others = memory_ - tiles_[tile].memory;
  if (others + needed > options_.memory_bytes) {
    tiles_[tile].working = true;  // not the one to be put to sleep
    const auto candidate = sleeper();
    tiles_[tile].working = false;
    if (candidate) {
      grant(*candidate, Work::sleep, tiles_[*candidate].memory);
      return true;
    }
    if (working_ + storing_ > 0) return false;
  }
  grant(tile, work, needed);
  return true;
}

// The idle tile in memory with the least mail; of equals, the largest.
std::optional<std::uint32_t> NodeActor::sleeper() const {
  std::optional<std::uint32_t> best;
  for (std::uint32_t t = 0; t < tiles_.size(); ++t) {
    const Tile& tile = tiles_[t];
    if (tile.stage != Stage::awake || tile.working) continue;
    const auto rank = [](const Tile& x) { return std::pair(x.mail, ~x.memory); };
    if (!best || rank(tile) < rank(tiles_[*best])) best = t;
  }
  return best;
}

void NodeActor::grant(std::uint32_t tile, Work work, std::uint64_t needed) {
  tiles_[tile].working = true;
  ++working_;
  memory_ += needed - tiles_[tile].memory;
  tiles_[tile].memory = needed;
  if (progress_ && !collecting_) {
    progress_->phase =
        work == Work::triangulate || next_fresh_ < tiles_.size() ? Phase::triangulating : Phase::splaying;
  }
  send(directory_.tiles[tile], Grant{work});
}

}  // namespace tessera
