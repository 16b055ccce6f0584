#include "actors/share_actor.h"

#include <algorithm>
#include <utility>

#include "actors/failing.h"
#include "actors/tile_actor.h"

namespace tessera {
namespace {

// More nodes than any job has.
constexpr std::uint32_t nodes_max = 1 << 16;

}  // namespace

ShareActor::ShareActor(caf::actor_config& config, NodeId self, ShareOptions options, std::shared_ptr<const Share> share,
                       CoordinatorHandle coordinator, Term term, Hooks hooks,
                       std::chrono::milliseconds progress_interval, std::shared_ptr<NodeMeter> meter)
    : SteadyActor(config),
      self_(self),
      share_(std::move(share)),
      directory_(std::make_shared<ActorDirectory>()),
      coordinator_(std::move(coordinator)),
      term_(term),
      schedule_(share_->stages.at(share_->table->stage).schedule, weights_on(self, *share_->table, *share_->weights)),
      table_(share_->table),
      outboxes_(share_->outboxes, share_->scratch),
      account_(self, progress_interval, share_->stored.size(), std::chrono::steady_clock::now()),
      meter_(std::move(meter)) {
  directory_->self = self;
  directory_->options = std::move(options);
  directory_->hooks = std::move(hooks);
  live_at(directory_->hooks.home);
  for (const TileReceipt& stored : share_->stored) schedule_.set_stored(stored.tile);
}

// Share, tiles and directory refer to each other, and each lets go of the directory as it ends. The directory itself is
// not changed, because a tile may be reading it at this moment.
void ShareActor::on_exit() {
  if (!directory_) return;
  meter_->end(id());
  stop_work();
  for (auto& [tile, hosted] : hosted_) hosted.leave.say(hosted.handle);
  ShareEnded& sum = account_.sum();
  if (state_ != State::ended && !sum.failure) sum.failure = ended_unexpectedly();
  last_message_.message() = std::move(sum);
  if (!silent_) last_message_.say(coordinator_);
  directory_ = nullptr;
  share_ = nullptr;
  coordinator_ = nullptr;
}

void ShareActor::failed(const std::exception_ptr& exception) noexcept {
  account_.sum().failure = failure_ ? std::move(*failure_) : failure_of(exception, [&] { return name_of(self_); });
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
        const Totals& totals = account_.totals();
        const ShareTally tally{self_, table_->epoch, probe.wave, idle(), totals.sent, totals.processed};
        directory_->hooks.tell([&] {
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
        stop(failure_of(error(Errc::interrupted, "no other coordinator has taken over the job in time")));
        dispatch();
      },
  };
}

void ShareActor::take(TileReport& report) {
  const WorkSpan& span = report.span;
  directory_->hooks.tell([&] {
    return name_of(self_) + ": tile " + std::to_string(span.tile.value) + " has done " + tessera::name_of(span.work) +
           ": sent " + std::to_string(report.sent) + ", processed " + std::to_string(report.processed) +
           ", updates waiting " + std::to_string(report.waiting.updates);
  });
  const auto found = hosted_.find(span.tile);
  if (found == hosted_.end()) return;
  account_.note(found->second.counts, report);
  if (report.failure) return abandon(span.tile, std::move(report.failure));
  if (!schedule_.working(span.tile)) return;  // given up while it worked, because its mail could not be kept
  schedule_.note_done(span.tile, span.work, report.memory,
                      {report.waiting.updates, report.waiting.bytes, report.waiting.memory, report.waiting.hops},
                      report.storing);
  if (span.work == Work::hand_over) account_.tile_is_handed_over(report.kept);
  if (span.work == Work::begin) account_.tile_has_begun(weights()[span.tile.value]);
}

void ShareActor::take(TileStored& stored) {
  if (stored.failure) return abandon(stored.tile, std::move(stored.failure));
  if (!schedule_.storing(stored.tile)) return;  // given up meanwhile
  schedule_.note_stored(stored.tile);
  account_.tile_is_stored();
  tell_stored({table_->stage, {stored.tile, std::move(stored.receipt)}, hosted_.at(stored.tile).counts.microseconds});
}

void ShareActor::abandon(TileId tile, Failure failure) {
  schedule_.abandon(tile);
  stop(std::move(failure));
}

// An error io is that of the node's own scratch, because what waits for other nodes lies there.
void ShareActor::stop_for_outbox(Error error) {
  outbox_failed_ = error.code == Errc::io;
  stop(failure_of(std::move(error)));
}

// Sends an update to the node that has the tile by the newest table. Drops it when the tile has another incarnation
// there.
void ShareActor::post(Update update) {
  if (failure_ || !table_->alive(update.to)) return;
  const NodeId to = table_->node_of(update.to.tile);
  if (to == self_) return deliver(self_, std::move(update));
  // That node is lost. A table to come says where the tile is.
  if (!directory_->routes()->share_of(to)) return;
  if (Status added = outboxes_.add(to, std::move(update)); !added) {
    stop_for_outbox(std::move(added).error());
    return dispatch();
  }
  send_packets(to);
}

void ShareActor::send_packets(NodeId to) {
  const ShareHandle there = directory_->routes()->share_of(to);
  while (true) {
    auto updates = outboxes_.next(to);
    if (!updates) {
      stop_for_outbox(std::move(updates).error());
      return dispatch();
    }
    if (updates.value().empty()) return;
    Packet packet{self_, outboxes_.window_bytes(), std::move(updates).value()};
    if (directory_->hooks.network) {
      send(directory_->hooks.network, caf::actor_cast<caf::actor>(there), std::move(packet));
    } else {
      send(there, std::move(packet));
    }
  }
}

void ShareActor::deliver(Packet& packet) {
  if (packet.from.value >= nodes_max) {  // something is kept for each node
    stop(failure_of(error(Errc::internal, name_of(self_) + " received mail from node " +
                                              std::to_string(packet.from.value) +
                                              ", but no job has a node of this number")));
    return dispatch();
  }
  if (packet.from != self_) owed_.note_window(packet.from, packet.window_bytes);
  for (Update& update : packet.updates) deliver(packet.from, std::move(update));
}

void ShareActor::keep_early(NodeId from, Update update) {
  if (early_.keep(from, std::move(update), nodes_)) return;
  stop(
      failure_of(error(Errc::internal, name_of(self_) + " received " + std::to_string(early_.bytes()) +
                                           " bytes of mail for routing tables that it does not have yet, which is more "
                                           "than other nodes may send")));
  dispatch();
}

void ShareActor::deliver_early() {
  for (EarlyMail::Early& early : early_.take()) deliver(early.from, std::move(early.update));
}

// Whatever another node sends, it never ends this process: an update for a tile that does not exist ends the job.
void ShareActor::deliver(NodeId from, Update update) {
  if (failure_) return;  // mail of a job that is over
  const auto routes = directory_->routes();
  if (!routes || update.epoch > table_->epoch) return keep_early(from, std::move(update));
  const TileId to = update.to.tile;
  const std::size_t tiles = weights().size();
  const bool sound = to.value < tiles && update.from.tile.value < tiles;
  // The update was sent by an older table; or the tile was given up, and its next incarnation is told again.
  const TileHandle handle = routes->tile(to);
  const bool gone = sound && (!table_->alive(update.to) || (handle && !hosts(to)));
  if (gone) return give_credit(from, Outbox::bytes_of(update));
  if (!sound || !handle) {
    stop(failure_of(error(Errc::internal, name_of(self_) + " received mail for tile " + std::to_string(to.value) +
                                              ", which is not on this node")));
    return dispatch();
  }
  send(handle, Delivery{from, std::move(update)});
}

void ShareActor::give_credit(NodeId to, std::uint64_t bytes) {
  if (to == self_ || failure_ || !owed_.add(to, bytes)) return;
  if (const ShareHandle there = directory_->routes()->share_of(to)) send(there, Credit{self_, owed_.give(to)});
}

void ShareActor::take(const Credit& credit) {
  if (!failure_ && outboxes_.taken(credit.from, credit.bytes)) send_packets(credit.from);
}

void ShareActor::stop(Failure failure) {
  if (failure_) return;
  // Settled tiles need no image: what makes them independent is on scratch.
  const bool images = failure.code == static_cast<std::uint8_t>(Errc::interrupted) && directory_->options.resumable &&
                      schedule_.mode() < Schedule::Mode::collecting && coordinator_;
  failure_ = std::move(failure);
  stop_work();
  early_.take();
  outboxes_.clear();
  schedule_.enter(images ? Schedule::Mode::suspending : Schedule::Mode::stopping);
}

// Work under way is of no use any more. Images that are being written are, and their writing does not look at the
// token.
void ShareActor::stop_work() noexcept {
  std::stop_source stopping = share_->stopping;
  stopping.request_stop();
}

void ShareActor::dispatch() {
  if (state_ == State::ended) return;
  while (const auto permit = opened() ? schedule_.next() : std::nullopt) {
    send(hosted_.at(permit->tile).handle, Permit{permit->work});
  }
  tell_progress(false);
  // A share that has failed does not wait for tiles to take the table: the tile may be the one that has ended.
  if (!schedule_.idle() || (!table_.is_taken() && !failure_)) {
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
      if (releases_.all_have_left()) end();
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
  account_.end(schedule_.sleeps(), outboxes_.counts());
  if (failure_) {
    const bool io = failure_->code == static_cast<std::uint8_t>(Errc::io);
    account_.sum().of_node = io && (outbox_failed_ || stage().context.storage->own_scratch_failed());
    account_.sum().failure = std::move(*failure_);
  }
  state_ = State::ended;
  quit();
}

void ShareActor::tell_progress(bool now) {
  if (!account_.is_due(std::chrono::steady_clock::now(), now, nodes_)) return;
  const ShareProgress& progress = account_.progress(schedule_.asleep(), schedule_.memory(), outboxes_.counts());
  meter_->tell(id(), account_.work(stored_before().size(), outboxes_.waiting_bytes()));
  if (!coordinator_) return;  // spans are kept for the next coordinator
  // The coordinator adds up the counts of all nodes ten times a second. With several nodes each tells fewer.
  if (share_->mail)
    account_.set_mail(share_->mail->take(stage().context.many_nodes ? mail_arcs_max / 4 : mail_arcs_max));
  tell(progress);
  account_.forget_spans();
}

}  // namespace tessera
