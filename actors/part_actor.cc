#include "actors/part_actor.h"

#include <algorithm>
#include <utility>

#include "actors/failing.h"
#include "actors/tile_actor.h"

namespace tessera {
namespace {

std::string name_of(NodeId node) { return "node " + std::to_string(node.value); }

}  // namespace

PartActor::PartActor(caf::actor_config& config, NodeId self, PartSpec spec, std::shared_ptr<const Part> part,
                     CoordinatorHandle coordinator, std::uint64_t term, Hooks hooks,
                     std::chrono::milliseconds progress_interval)
    : SteadyActor(config),
      self_(self),
      part_(std::move(part)),
      office_(std::make_shared<Office>()),
      coordinator_(std::move(coordinator)),
      term_(term),
      schedule_(part_->schedule, part_->points),
      progress_interval_(progress_interval) {
  office_->self = self;
  table_ = std::make_shared<const Table>(std::move(spec.table));
  office_->options = std::move(spec);
  office_->hooks = std::move(hooks);
  live_at(office_->hooks.home);
  sum_.node = progress_.node = self;
  progress_told_ = std::chrono::steady_clock::now();
  for (const TileEntry& entry : part_->stored) {
    schedule_.set_stored(entry.tile);
    ++progress_.tiles_stored;
  }
}

// Part, tiles and office know each other: each lets go of the office as it ends. The office stays as it is: a tile may
// be reading it at this moment.
void PartActor::on_exit() {
  if (!office_) return;
  stop_work();
  for (Hosted& hosted : hosted_) hosted.leave.say(hosted.handle);
  if (!ended_ && !sum_.failure) sum_.failure = ended_unexpectedly();
  last_word_.message() = std::move(sum_);
  last_word_.say(coordinator_);
  office_ = nullptr;
  part_ = nullptr;
  coordinator_ = nullptr;
}

void PartActor::failed(const std::exception_ptr& exception) noexcept {
  sum_.failure = failure_ ? std::move(*failure_) : failure_of(exception, [&] { return name_of(self_); });
}

PartActor::behavior_type PartActor::make_behavior() {
  monitor(coordinator_);
  set_down_handler([this](caf::scheduled_actor*, caf::down_msg& down) {
    lost_coordinator(down);
    dispatch();
  });
  set_error_handler([this](caf::scheduled_actor*, caf::error& reason) {
    stop(lost("a message of " + name_of(self_), reason));
    dispatch();
  });
  return {
      [this](BeginPart& begin) {
        if (!obeyed()) return;
        open(begin);
        dispatch();
      },
      [this](ChangeTable& change) {
        if (!obeyed()) return;
        change_table(change);
        dispatch();
      },
      [this](const FindPart& found) {
        obey(found);
        dispatch();
      },
      [this](const Finish&) {
        if (obeyed() && !failure_) end();
      },
      [this](const Release& wanted) {
        if (obeyed()) release(wanted);
      },
      [this](const TileRejoined& rejoined) {
        take(rejoined);
        dispatch();
      },
      [this](const Probe& probe) {
        if (!obeyed()) return;
        const PartTally tally{self_, table_->epoch, probe.wave, idle(), totals_.sent, totals_.processed};
        office_->hooks.tell([&] {
          return name_of(self_) + ": wave " + std::to_string(probe.wave) + (tally.idle ? ": idle" : ": busy") +
                 ", sent " + std::to_string(tally.sent) + ", processed " + std::to_string(tally.processed);
        });
        tell(tally);
      },
      [this](const Settle&) {
        if (!obeyed()) return;
        if (!failure_) schedule_.enter(Schedule::Stage::settling);
        dispatch();
      },
      [this](const Collect&) {
        if (!obeyed()) return;
        enter_collecting();
        dispatch();
      },
      [this](const Suspend&) {
        if (!obeyed()) return;
        stop(failure_of(error(Errc::interrupted, "interrupted")));
        dispatch();
      },
      [this](const Abort& abort) {
        if (abort.term != term_) return;
        stop(failure_of(error(Errc::interrupted, "given up")));
        dispatch();
      },
      [this](Parcel& parcel) { deliver(parcel); },
      [this](const MailNotice& notice) {
        schedule_.mail(notice.tile, {notice.updates, notice.points, notice.bytes, notice.hops});
        dispatch();
      },
      [this](TileReport& report) {
        take(report);
        dispatch();
      },
      [this](TileFailed& failed) {
        abandon(failed.tile, std::move(failed.failure));
        dispatch();
      },
      [this](TileStored& stored) {
        take(stored);
        dispatch();
      },
      [this](const GraceOver& over) {
        if (coordinator_ || over.term != term_) return;
        stop(failure_of(error(Errc::interrupted, "no coordinator has taken over")));
        dispatch();
      },
  };
}

void PartActor::open(BeginPart& begin) {
  office_->part = caf::actor_cast<PartHandle>(this);
  const std::size_t tiles = part_->tile_points.size();
  tiles_.resize(tiles);
  if (!begin.table.nodes.empty()) table_ = std::make_shared<const Table>(std::move(begin.table));
  go_by(table_, begin.parts);
  opened_ = true;
  if (begin.settled) return enter_collecting();
}

// Whoever is here by the table and was not has come; whoever is not any more was fresh, and has been released.
void PartActor::go_by(std::shared_ptr<const Table> table, const std::vector<caf::actor>& parts) {
  auto routes = std::make_shared<Routes>();
  routes->table = table;
  routes->tiles.resize(part_->tile_points.size());
  for (const caf::actor& part : parts) routes->parts.push_back(caf::actor_cast<PartHandle>(part));
  for (const Hosted& hosted : hosted_) routes->tiles[hosted.tile.value] = hosted.handle;
  for (std::uint32_t t = 0; t < part_->tile_points.size(); ++t) {
    if (part_->tile_points[t] == 0 || table->node_of(TileId{t}) != self_ || routes->tiles[t]) continue;
    hosted_.push_back({TileId{t}, {}, {}});  // first: what is there must be told to leave
    hosted_.back().handle =
        spawn<TileActor>(table->peer_of(TileId{t}), part_, std::shared_ptr<const Office>(office_), table);
    routes->tiles[t] = hosted_.back().handle;
    if (opened_) schedule_.add(TileId{t}, part_->tile_points[t]);
  }
  office_->set_routes(std::move(routes));
  table_ = std::move(table);
}

void PartActor::change_table(ChangeTable& change) {
  if (failure_ || !opened_ || change.table.epoch <= table_->epoch) return;
  office_->hooks.tell([&] { return name_of(self_) + ": epoch " + std::to_string(change.table.epoch); });
  const bool sound = change.table.nodes.size() == tiles_.size() && change.table.incarnations.size() == tiles_.size() &&
                     std::all_of(change.table.nodes.begin(), change.table.nodes.end(),
                                 [&](NodeId node) { return node.value < change.parts.size(); });
  if (!sound) return stop(failure_of(error(Errc::internal, name_of(self_) + " got a table that is not of its job")));
  if (schedule_.stage() == Schedule::Stage::settling) schedule_.enter(Schedule::Stage::exchanging);
  told_settled_ = told_collected_ = false;
  const std::size_t before = hosted_.size();
  go_by(std::make_shared<const Table>(std::move(change.table)), change.parts);
  if (schedule_.stage() == Schedule::Stage::exchanging) {
    rejoining_ = static_cast<std::uint32_t>(before);
    for (std::size_t i = 0; i < before; ++i) send(hosted_[i].handle, Rejoin{});
  }
  Parcel waiting;
  waiting.updates = std::exchange(early_, {});
  deliver(waiting);
}

// Their mail goes with them: what they were told they are told again, as other incarnations.
void PartActor::release(const Release& wanted) {
  PartReleased released{self_, {}};
  const bool can = !failure_ && opened_ && rejoining_ == 0 && schedule_.stage() != Schedule::Stage::settling;
  if (can) released.tiles = schedule_.release(wanted.points);
  for (const TileId tile : released.tiles) {
    const auto hosted = std::find_if(hosted_.begin(), hosted_.end(), [&](const Hosted& h) { return h.tile == tile; });
    hosted->leave.say(hosted->handle);
    hosted_.erase(hosted);
    note(tile, {});
  }
  tell(std::move(released));
}

// What another node says is never a reason to stop this one: an update for nobody ends the job, not the process.
void PartActor::deliver(Parcel& parcel) {
  if (failure_) return;  // mail of a job that is over
  const auto routes = office_->routes();
  for (Update& update : parcel.updates) {
    if (!routes || update.epoch > table_->epoch) {
      early_.push_back(std::move(update));
      continue;
    }
    const TileId to = update.to.tile;
    const std::size_t tiles = part_->tile_points.size();
    const bool sound = to.value < tiles && update.from.tile.value < tiles;
    if (sound && !table_->alive(update.to)) continue;  // sent by an older table
    if (!sound || !routes->tiles[to.value]) {
      stop(failure_of(error(Errc::internal, name_of(self_) + " got mail for tile " + std::to_string(to.value) +
                                                ", which it does not have")));
      dispatch();
      return;
    }
    send(routes->tiles[to.value], std::move(update));
  }
}

void PartActor::note(TileId tile, Totals totals) {
  Totals& before = tiles_[tile.value].totals;
  totals_.sent += totals.sent - before.sent;
  totals_.processed += totals.processed - before.processed;
  before = totals;
}

void PartActor::take(const TileRejoined& rejoined) {
  note(rejoined.tile, {rejoined.sent, rejoined.processed});
  const MailNotice& mail = rejoined.waiting;
  schedule_.mail(rejoined.tile, {mail.updates, mail.points, mail.bytes, mail.hops});
  if (rejoined.epoch == table_->epoch && rejoining_ > 0) --rejoining_;
}

void PartActor::take(TileReport& report) {
  const WorkSpan& span = report.span;
  office_->hooks.tell([&] {
    return name_of(self_) + ": tile " + std::to_string(span.tile.value) + " has done " + tessera::name_of(span.work) +
           ": sent " + std::to_string(report.sent) + ", processed " + std::to_string(report.processed) +
           ", updates waiting " + std::to_string(report.waiting.updates);
  });
  Figures& tile = tiles_[span.tile.value];
  note(span.tile, {report.sent, report.processed});
  sum_.updates += report.updates - tile.updates;
  tile.updates = report.updates;
  sum_.points += report.points;
  sum_.points -= tile.points;
  tile.points = report.points;
  sum_.hops = std::max<std::uint64_t>(sum_.hops, report.hops);
  sum_.most_received = std::max(sum_.most_received, report.points.received);
  const std::uint64_t us = span.end_us - span.begin_us;
  tile.microseconds += us;
  (span.work == Work::begin ? sum_.begin_us : span.work == Work::collect ? sum_.collect_us : sum_.splay_us) += us;
  progress_.spans.push_back(span);
  if (report.failure) return abandon(span.tile, std::move(report.failure));
  if (!schedule_.working(span.tile)) return;  // given up while it worked: its mail could not be kept
  schedule_.done(span.tile, span.work, report.memory,
                 {report.waiting.updates, report.waiting.points, report.waiting.bytes, report.waiting.hops},
                 report.storing);
  if (span.work == Work::begin) {
    ++progress_.tiles_begun;
    progress_.points_begun += part_->tile_points[span.tile.value];
  }
}

void PartActor::take(TileStored& stored) {
  if (stored.failure) return abandon(stored.tile, std::move(stored.failure));
  if (!schedule_.storing(stored.tile)) return;  // given up meanwhile
  schedule_.stored(stored.tile);
  ++progress_.tiles_stored;
  tell_stored({stored.entry, tiles_[stored.tile.value].microseconds});
}

// The tiles go on: what they say meanwhile is said again to whoever takes over.
void PartActor::lost_coordinator(const caf::down_msg& down) {
  if (!coordinator_ || down.source != coordinator_.address()) return;
  coordinator_ = nullptr;
  if (office_->options.grace_s == 0 || failure_) return stop(lost("the coordinator", down.reason));
  delayed_send(this, std::chrono::seconds(office_->options.grace_s), GraceOver{term_});
}

void PartActor::abandon(TileId tile, Failure failure) {
  schedule_.abandon(tile);
  stop(std::move(failure));
}

void PartActor::stop(Failure failure) {
  if (failure_) return;
  // Settled tiles need no image: what makes them independent is on scratch.
  const bool images = failure.code == static_cast<std::uint8_t>(Errc::interrupted) && office_->options.resumable &&
                      schedule_.stage() < Schedule::Stage::collecting && coordinator_;
  failure_ = std::move(failure);
  stop_work();
  schedule_.enter(images ? Schedule::Stage::suspending : Schedule::Stage::stopping);
}

// What is under way is of no use any more. Images that are being written are: they take no notice.
void PartActor::stop_work() noexcept {
  std::stop_source stopping = part_->stopping;
  stopping.request_stop();
}

void PartActor::dispatch() {
  if (ended_) return;
  while (const auto grant = opened_ ? schedule_.next() : std::nullopt) {
    send(office_->routes()->tiles[grant->tile.value], Grant{grant->work});
  }
  tell_progress(false);
  if (!schedule_.idle() || rejoining_ > 0) {
    const bool begun = opened_ && schedule_.stage() == Schedule::Stage::exchanging && schedule_.all_begun();
    if (begun && !std::exchange(told_begun_, true)) tell(PartBegun{self_});
    return;
  }
  switch (schedule_.stage()) {
    case Schedule::Stage::exchanging:
      if (!opened_) return;
      if (!std::exchange(told_begun_, true)) tell(PartBegun{self_});
      tell(PartIdle{self_});
      return;
    case Schedule::Stage::settling:
      if (!std::exchange(told_settled_, true)) tell(PartSettled{self_, table_->epoch});
      return;
    case Schedule::Stage::collecting:
      if (!std::exchange(told_collected_, true)) tell(PartCollected{self_, table_->epoch});
      return;
    case Schedule::Stage::suspending:
    case Schedule::Stage::stopping:
      return end();
  }
}

void PartActor::enter_collecting() {
  if (failure_ || schedule_.stage() == Schedule::Stage::collecting) return;
  schedule_.enter(Schedule::Stage::collecting);
  for (const TileEntry& entry : part_->stored) tell_stored({entry, 0});  // by an earlier process
}

void PartActor::tell_stored(TileDone done) {
  stored_.push_back(std::move(done));
  tell(stored_.back());
}

// Messages of one that has been replaced, and does not know it yet.
bool PartActor::obeyed() {
  return coordinator_ && current_sender() == caf::actor_cast<caf::strong_actor_ptr>(coordinator_);
}

// Whatever has been said to the one before may not have been heard.
void PartActor::obey(const FindPart& found) {
  if (found.term <= term_ || ended_) return;
  term_ = found.term;
  if (coordinator_) demonitor(coordinator_.address());
  coordinator_ = caf::actor_cast<CoordinatorHandle>(found.coordinator);
  monitor(coordinator_);
  told_begun_ = told_settled_ = told_collected_ = false;
  tell(PartFound{term_, found.node, caf::actor_cast<caf::actor>(this), self_, opened_, *table_,
                 part_->schedule.threads});
  for (const TileDone& done : stored_) tell(done);
}

void PartActor::end() {
  tell_progress(true);
  sum_.sleeps = schedule_.sleeps();
  if (failure_) sum_.failure = std::move(*failure_);
  ended_ = true;
  quit();
}

void PartActor::tell_progress(bool now) {
  const auto time = std::chrono::steady_clock::now();
  if (!coordinator_ || (!now && time - progress_told_ < progress_interval_)) return;
  progress_told_ = time;
  progress_.tiles_asleep = schedule_.asleep();
  progress_.updates_sent = totals_.sent;
  progress_.updates_processed = totals_.processed;
  progress_.points_sent = sum_.points.sent;
  progress_.memory_bytes = schedule_.memory();
  tell(progress_);
  progress_.spans.clear();
}

}  // namespace tessera
