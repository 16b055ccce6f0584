// Which tiles a share has, by which routing table, and which coordinator it obeys.
#include <algorithm>
#include <utility>

#include "actors/failing.h"
#include "actors/share_actor.h"
#include "actors/tile_actor.h"

namespace tessera {

// Goes by the table in BeginShare and not by the one with which the share was opened, because between the two nodes may
// be lost and another coordinator may take over. Mostly the tables are equal, and then memory holds one copy.
void ShareActor::open(const BeginShare& begin) {
  if (!begin.table.nodes.empty() && !is_of_job(begin.table, begin.shares)) return stop(not_of_job());
  directory_->share = caf::actor_cast<ShareHandle>(this);
  if (!begin.table.nodes.empty() && begin.table != *table_)
    table_.set(std::make_shared<const RoutingTable>(begin.table));
  schedule_ = Schedule(stage().schedule, weights_on(self_, *table_, weights()));
  for (const TileReceipt& stored : stored_before()) schedule_.set_stored(stored.tile);
  account_.begin(stored_before().size());
  go_by(table_.shared(), begin.shares);
  state_ = State::open;
  if (begin.settled) enter_collecting();
  deliver_early();
}

// Nothing of the stage before is under way, because all its tiles have come to their end.
void ShareActor::begin_stage(const RoutingTable& table) {
  directory_->hooks.tell([&] { return name_of(self_) + ": stage " + std::to_string(table.stage); });
  for (auto& [tile, hosted] : hosted_) hosted.leave.say(hosted.handle);
  hosted_.clear();
  account_.begin_next_stage(stored_before().size(), schedule_.sleeps());
  schedule_ = Schedule(share_->stages.at(table.stage).schedule, {});
  stored_.clear();
  table_.forget_changes();
  said_.forget(ShareEvent::begun);
}

bool ShareActor::is_of_job(const RoutingTable& table, const std::vector<caf::actor>& shares) const {
  return is_table_of_job(table, weights().size(), share_->stages.size(), shares.size());
}

Failure ShareActor::not_of_job() const {
  return failure_of(error(Errc::internal, name_of(self_) + " received a routing table that does not fit its job"));
}

// Tiles that are new on this node by the table are added. Tiles that are not on it any more were fresh, and have been
// released.
void ShareActor::go_by(std::shared_ptr<const RoutingTable> table, const std::vector<caf::actor>& shares) {
  auto routes = std::make_shared<Routes>();
  nodes_ = shares.size();
  routes->table = table;
  routes->rebirths = table_.changes();
  for (const caf::actor& share : shares) routes->shares.push_back(caf::actor_cast<ShareHandle>(share));
  for (std::uint32_t t = 0; t < weights().size(); ++t) {
    if (weights()[t] == 0 || table->node_of(TileId{t}) != self_ || hosts(TileId{t})) continue;
    Hosted& hosted = hosted_[TileId{t}];  // first: a tile that exists must be in hosted_, to be told to leave
    hosted.handle =
        spawn<TileActor>(table->peer_of(TileId{t}), share_, std::shared_ptr<const ActorDirectory>(directory_), table);
    if (opened()) schedule_.add(TileId{t}, weights()[t]);
  }
  routes->tiles.reserve(hosted_.size());
  for (const auto& [tile, hosted] : hosted_) routes->tiles.emplace_back(tile, hosted.handle);
  directory_->set_routes(std::move(routes));
  table_.set(std::move(table));
}

void ShareActor::change_table(ChangeTable& change) {
  if (failure_ || !opened() || change.table.epoch <= table_->epoch) return;
  directory_->hooks.tell([&] { return name_of(self_) + ": epoch " + to_string(change.table.epoch); });
  if (!is_of_job(change.table, change.shares)) return stop(not_of_job());
  if (change.table.stage != table_->stage) {
    // The next stage begins when all tiles of all shares have come to the end of the stage before.
    const bool next = change.table.stage > table_->stage && schedule_.mode() == Schedule::Mode::collecting &&
                      schedule_.idle() && !change.settled;
    if (!next) return stop(not_of_job());
    begin_stage(change.table);
  }
  if (change.settled) {
    enter_collecting();
  } else if (schedule_.mode() == Schedule::Mode::settling) {
    schedule_.enter(Schedule::Mode::exchanging);
  }
  for (const ShareEvent event : {ShareEvent::idle, ShareEvent::settled, ShareEvent::collected}) said_.forget(event);
  const bool rejoins = schedule_.mode() == Schedule::Mode::exchanging;
  if (rejoins) table_.add_changes(change.table);
  std::vector<TileHandle> before;
  for (const auto& [tile, hosted] : hosted_) before.push_back(hosted.handle);
  go_by(std::make_shared<const RoutingTable>(std::move(change.table)), change.shares);
  const auto routes = directory_->routes();
  outboxes_.clear_unless([&](NodeId node) { return routes->share_of(node) != nullptr; });
  if (rejoins) {
    table_.wait_for(static_cast<std::uint32_t>(before.size()));
    for (const TileHandle& tile : before) send(tile, Rejoin{});
  }
  deliver_early();
}

void ShareActor::take(const TileRejoined& rejoined) {
  const auto found = hosted_.find(rejoined.tile);
  if (found == hosted_.end()) return;  // given up since it sent this
  Hosted& tile = found->second;
  account_.note(tile.counts, Totals{rejoined.sent, rejoined.processed});
  const MailNotice& mail = rejoined.waiting;
  schedule_.note_mail(rejoined.tile, {mail.updates, mail.bytes, mail.memory, mail.hops});
  table_.take(tile.epoch, rejoined.epoch);
}

// The mail of released tiles goes with them. Their next incarnations are told all of it again.
void ShareActor::release(const Release& wanted) {
  std::vector<TileId> released;
  const bool can = !failure_ && opened() && table_.is_taken() && schedule_.mode() != Schedule::Mode::settling &&
                   schedule_.mode() != Schedule::Mode::handing;
  if (can) released = schedule_.release(wanted.weight);
  for (const TileId tile : released) {
    const auto hosted = hosted_.find(tile);
    send(hosted->second.handle, Leave{true});
    account_.note(hosted->second.counts, Totals{});
    hosted_.erase(hosted);
    releases_.give_up(tile);
  }
  releases_.ask();
  answer_if_left();
}

void ShareActor::take(const TileLeft&) {
  releases_.leave();
  answer_if_left();
}

// Tiles that have not begun need nothing: other nodes begin them. A tile that was handed over hears nothing any more,
// and is told again where it goes on. The share may be settling. When another node was lost meanwhile, the job
// exchanges again, but there is no new table before some node takes the tiles of the lost one.
void ShareActor::hand_over() {
  if (failure_ || !opened() || schedule_.mode() > Schedule::Mode::settling) return;
  directory_->hooks.tell([&] { return name_of(self_) + ": hands over"; });
  schedule_.enter(Schedule::Mode::handing);
}

// Answers what was asked once no tile is about to leave (src/exchange/tile_releases.h).
void ShareActor::answer_if_left() {
  if (!releases_.all_have_left()) return;
  while (std::optional<std::vector<TileId>> tiles = releases_.answer()) tell(ShareReleased{self_, std::move(*tiles)});
  // A coordinator that takes over then finds no share here. The images say that the tiles were handed over.
  if (!finder_ || schedule_.mode() == Schedule::Mode::handing) return;
  ShareFound answer;
  answer.term = term_;
  answer.node = finder_->node;
  answer.share = caf::actor_cast<caf::actor>(this);
  answer.self = self_;
  answer.begun = opened();
  answer.table = *table_;
  answer.threads = stage().schedule.threads;
  answer.memory_bytes = directory_->options.memory_bytes;
  answer.name = finder_->name;
  for (std::uint32_t t = 0; opened() && t < weights().size(); ++t) {
    if (table_->node_of(TileId{t}) == self_ && weights()[t] > 0 && !hosts(TileId{t})) {
      answer.released.push_back(TileId{t});
    }
  }
  finder_.reset();
  tell(std::move(answer));
  for (const TileDone& done : stored_) tell(done);
}

// Returns false for messages of a coordinator that was replaced and does not know it yet.
bool ShareActor::obeyed() {
  return coordinator_ && current_sender() == caf::actor_cast<caf::strong_actor_ptr>(coordinator_);
}

// What was said to the coordinator before may not have been heard, so all of it is said again.
void ShareActor::obey(const FindShare& found) {
  if (found.term <= term_ || state_ == State::ended) return;
  term_ = found.term;
  if (coordinator_) demonitor(coordinator_.address());
  coordinator_ = caf::actor_cast<CoordinatorHandle>(found.coordinator);
  monitor(coordinator_);
  said_.forget_all();
  releases_.forget_asked();
  finder_ = found;
  answer_if_left();
}

// The tiles go on. What they say meanwhile is said again to the coordinator that takes over.
void ShareActor::lost_coordinator(const caf::down_msg& down) {
  if (!coordinator_ || down.source != coordinator_.address()) return;
  coordinator_ = nullptr;
  if (directory_->options.grace_s == 0 || failure_) return stop(lost("the coordinator", down.reason));
  delayed_send(this, std::chrono::seconds(directory_->options.grace_s), GraceOver{term_});
}

}  // namespace tessera
