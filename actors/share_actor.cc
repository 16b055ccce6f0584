#include "actors/share_actor.h"

#include <algorithm>
#include <utility>

#include "actors/failing.h"
#include "actors/tile_actor.h"

namespace tessera {
namespace {

// Many small tiles make many spans in a moment. The spans are sent before they take more memory than the tiles.
constexpr std::size_t spans_max = 1000;
// Up to so many nodes send progress at the shortest interval. With more nodes each waits longer, so that the
// coordinator has no more to do.
constexpr std::size_t nodes_at_once = 50;

}  // namespace

ShareActor::ShareActor(caf::actor_config& config, NodeId self, ShareOptions options, std::shared_ptr<const Share> part,
                       CoordinatorHandle coordinator, Term term, Hooks hooks,
                       std::chrono::milliseconds progress_interval, std::shared_ptr<NodeMeter> meter)
    : SteadyActor(config),
      self_(self),
      part_(std::move(part)),
      office_(std::make_shared<ActorDirectory>()),
      coordinator_(std::move(coordinator)),
      term_(term),
      schedule_(part_->stages.at(part_->table->stage).schedule, weights_by(*part_->table)),
      table_(part_->table),
      progress_interval_(progress_interval),
      meter_(std::move(meter)) {
  office_->self = self;
  office_->options = std::move(options);
  office_->hooks = std::move(hooks);
  live_at(office_->hooks.home);
  sum_.node = progress_.node = self;
  progress_told_ = std::chrono::steady_clock::now();
  for (const TileReceipt& stored : part_->stored) {
    schedule_.set_stored(stored.tile);
    ++progress_.tiles_stored;
  }
}

// Share, tiles and directory refer to each other, and each lets go of the directory as it ends. The directory itself is
// not changed, because a tile may be reading it at this moment.
void ShareActor::on_exit() {
  if (!office_) return;
  meter_->end(id());
  stop_work();
  for (auto& [tile, hosted] : hosted_) hosted.leave.say(hosted.handle);
  if (state_ != State::ended && !sum_.failure) sum_.failure = ended_unexpectedly();
  last_word_.message() = std::move(sum_);
  if (!silent_) last_word_.say(coordinator_);
  office_ = nullptr;
  part_ = nullptr;
  coordinator_ = nullptr;
}

void ShareActor::failed(const std::exception_ptr& exception) noexcept {
  sum_.failure = failure_ ? std::move(*failure_) : failure_of(exception, [&] { return name_of(self_); });
}

ShareActor::behavior_type ShareActor::make_behavior() {
  meter_->tell(id(), {});  // the share is there
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
      [this](const BeginShare& begin) {
        if (!obeyed() || opened()) return;  // once, even if another coordinator sends it again
        open(begin);
        dispatch();
      },
      [this](ChangeTable& change) {
        if (!obeyed()) return;
        change_table(change);
        dispatch();
      },
      [this](const FindShare& found) {
        obey(found);
        dispatch();
      },
      [this](const Finish&) {
        if (obeyed() && !failure_) end();
      },
      [this](const Release& wanted) {
        if (obeyed()) release(wanted);
      },
      [this](const HandOver&) {
        if (obeyed()) hand_over();
        dispatch();
      },
      [this](const TileRejoined& rejoined) {
        take(rejoined);
        dispatch();
      },
      [this](const Probe& probe) {
        if (!obeyed()) return;
        const ShareTally tally{self_, table_->epoch, probe.wave, idle(), totals_.sent, totals_.processed};
        office_->hooks.tell([&] {
          return name_of(self_) + ": wave " + to_string(probe.wave) + (tally.idle ? ": idle" : ": busy") + ", sent " +
                 std::to_string(tally.sent) + ", processed " + std::to_string(tally.processed);
        });
        said_.forget(ShareEvent::idle);
        tell(tally);
      },
      [this](const Settle&) {
        if (!obeyed()) return;
        if (!failure_ && schedule_.mode() <= Schedule::Mode::settling) schedule_.enter(Schedule::Mode::settling);
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
      [this](Packet& packet) { deliver(packet); },
      [this](Outgoing& outgoing) { post(std::move(outgoing.update)); },
      [this](const Taken& taken) { give_credit(taken.from, taken.bytes); },
      [this](const Credit& credit) { take(credit); },
      [this](const MailNotice& notice) {
        schedule_.note_mail(notice.tile, {notice.updates, notice.bytes, notice.memory, notice.hops});
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
      // Without a last message: the coordinator takes the node for lost.
      [this](const Leave&) {
        silent_ = true;
        stop(failure_of(error(Errc::interrupted, "the node leaves")));
        dispatch();
      },
      [this](const TileLeft& left) {
        take(left);
        if (schedule_.mode() == Schedule::Mode::handing) dispatch();
      },
      [this](const GraceOver& over) {
        if (coordinator_ || over.term != term_) return;
        stop(failure_of(error(Errc::interrupted, "no coordinator has taken over")));
        dispatch();
      },
  };
}

void ShareActor::note(Hosted& tile, Totals totals) {
  Totals& before = tile.totals;
  totals_.sent += totals.sent - before.sent;
  totals_.processed += totals.processed - before.processed;
  before = totals;
}

void ShareActor::take(TileReport& report) {
  const WorkSpan& span = report.span;
  office_->hooks.tell([&] {
    return name_of(self_) + ": tile " + std::to_string(span.tile.value) + " has done " + tessera::name_of(span.work) +
           ": sent " + std::to_string(report.sent) + ", processed " + std::to_string(report.processed) +
           ", updates waiting " + std::to_string(report.waiting.updates);
  });
  const auto found = hosted_.find(span.tile);
  if (found == hosted_.end()) return;
  Hosted& tile = found->second;
  note(tile, {report.sent, report.processed});
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
  if (report.failure) return abandon(span.tile, std::move(report.failure));
  if (!schedule_.working(span.tile)) return;  // given up while it worked, because its mail could not be kept
  schedule_.note_done(span.tile, span.work, report.memory,
                      {report.waiting.updates, report.waiting.bytes, report.waiting.memory, report.waiting.hops},
                      report.storing);
  if (span.work == Work::hand_over) ++(report.kept ? sum_.handed : sum_.not_handed);
  if (span.work == Work::begin) {
    ++progress_.tiles_begun;
    progress_.weight_begun += weights()[span.tile.value];
  }
}

void ShareActor::take(TileStored& stored) {
  if (stored.failure) return abandon(stored.tile, std::move(stored.failure));
  if (!schedule_.storing(stored.tile)) return;  // given up meanwhile
  schedule_.note_stored(stored.tile);
  ++progress_.tiles_stored;
  tell_stored({table_->stage, {stored.tile, std::move(stored.receipt)}, hosted_.at(stored.tile).microseconds});
}

void ShareActor::abandon(TileId tile, Failure failure) {
  schedule_.abandon(tile);
  stop(std::move(failure));
}

void ShareActor::stop(Failure failure) {
  if (failure_) return;
  // Settled tiles need no image: what makes them independent is on scratch.
  const bool images = failure.code == static_cast<std::uint8_t>(Errc::interrupted) && office_->options.resumable &&
                      schedule_.mode() < Schedule::Mode::collecting && coordinator_;
  failure_ = std::move(failure);
  stop_work();
  std::vector<Delivery>().swap(early_);
  end_gates();
  schedule_.enter(images ? Schedule::Mode::suspending : Schedule::Mode::stopping);
}

// Work under way is of no use any more. Images that are being written are, and their writing does not look at the
// token.
void ShareActor::stop_work() noexcept {
  std::stop_source stopping = part_->stopping;
  stopping.request_stop();
}

void ShareActor::dispatch() {
  if (state_ == State::ended) return;
  while (const auto permit = opened() ? schedule_.next() : std::nullopt) {
    send(hosted_.at(permit->tile).handle, Permit{permit->work});
  }
  tell_progress(false);
  // A share that has failed does not wait for tiles to take the table: the tile may be the one that has ended.
  if (!schedule_.idle() || (rejoining_ > 0 && !failure_)) {
    const bool begun = opened() && schedule_.mode() == Schedule::Mode::exchanging && schedule_.all_begun();
    if (begun && said_.mark_told(ShareEvent::begun)) tell(ShareBegun{self_});
    return;
  }
  switch (schedule_.mode()) {
    case Schedule::Mode::exchanging:
      if (!opened()) return;
      if (said_.mark_told(ShareEvent::begun)) tell(ShareBegun{self_});
      if (said_.mark_told(ShareEvent::idle)) tell(ShareIdle{self_});
      return;
    case Schedule::Mode::settling:
      if (!said_.mark_told(ShareEvent::settled)) return;
      if (stage().sync_settled) {
        if (Status synced = stage().sync_settled(); !synced) {
          stop(failure_of(std::move(synced).error()));
          return dispatch();
        }
      }
      return tell(ShareSettled{self_, table_->epoch});
    case Schedule::Mode::collecting:
      if (said_.mark_told(ShareEvent::collected)) tell(ShareCollected{self_, table_->epoch});
      return;
    case Schedule::Mode::handing:
      if (leaving_ == 0) end();
      return;
    case Schedule::Mode::suspending:
    case Schedule::Mode::stopping:
      return end();
  }
}

void ShareActor::enter_collecting() {
  if (failure_ || schedule_.mode() >= Schedule::Mode::collecting) return;
  schedule_.enter(Schedule::Mode::collecting);
  for (const TileReceipt& tile : stored_before()) tell_stored({table_->stage, tile, 0});
}

void ShareActor::tell_stored(TileDone done) {
  stored_.push_back(std::move(done));
  tell(stored_.back());
}

void ShareActor::end() {
  tell_progress(true);
  sum_.sleeps += schedule_.sleeps();
  for (const auto& [node, outbox] : outboxes_) sum_.outboxes += outbox.counts();
  if (failure_) {
    const bool io = failure_->code == static_cast<std::uint8_t>(Errc::io);
    sum_.of_node = io && (gate_failed_ || stage().context.storage->own_scratch_failed());
    sum_.failure = std::move(*failure_);
  }
  state_ = State::ended;
  quit();
}

void ShareActor::tell_progress(bool now) {
  const auto time = std::chrono::steady_clock::now();
  const bool due = now || progress_.spans.size() >= spans_max ||
                   time - progress_told_ >= progress_interval_ * std::max<std::size_t>(1, nodes_ / nodes_at_once);
  if (!due) return;
  progress_told_ = time;
  progress_.tiles_asleep = schedule_.asleep();
  progress_.updates_sent = totals_.sent;
  progress_.updates_processed = totals_.processed;
  progress_.items_sent = sum_.items.sent;
  progress_.memory_bytes = schedule_.memory();
  progress_.outboxes = {};
  std::uint64_t waiting = 0;
  for (const auto& [node, outbox] : outboxes_) {
    progress_.outboxes += outbox.counts();
    waiting += outbox.waiting_bytes();
  }
  meter_->tell(id(), {0, progress_.tiles_asleep, progress_.memory_bytes, waiting,
                      before_.tiles_begun + progress_.tiles_begun, before_.weight_begun + progress_.weight_begun,
                      before_.tiles_stored + progress_.tiles_stored - stored_before().size(), progress_.outboxes});
  if (!coordinator_) return;  // spans are kept for the next coordinator
  // The coordinator adds up the counts of all nodes ten times a second. With several nodes each tells fewer.
  if (part_->mail) progress_.mail = part_->mail->take(stage().context.many_nodes ? mail_arcs_max / 4 : mail_arcs_max);
  tell(progress_);
  std::vector<WorkSpan>().swap(progress_.spans);
}

}  // namespace tessera
