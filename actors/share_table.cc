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
  if (!begin.table.nodes.empty() && !is_of_job(begin.table, begin.parts)) return stop(not_of_job());
  office_->part = caf::actor_cast<ShareHandle>(this);
  if (!begin.table.nodes.empty() && begin.table != *table_) table_ = std::make_shared<const RoutingTable>(begin.table);
  schedule_ = Schedule(stage().schedule, weights_by(*table_));
  for (const TileReceipt& stored : stored_before()) schedule_.set_stored(stored.tile);
  progress_.tiles_stored = stored_before().size();
  go_by(table_, begin.parts);
  state_ = State::open;
  if (begin.settled) enter_collecting();
  deliver_early();
}

// Nothing of the stage before is under way, because all its tiles have come to their end.
void ShareActor::begin_stage(const RoutingTable& table) {
  office_->hooks.tell([&] { return name_of(self_) + ": stage " + std::to_string(table.stage); });
  for (auto& [tile, hosted] : hosted_) hosted.leave.say(hosted.handle);
  hosted_.clear();
  before_.tiles_begun += progress_.tiles_begun;
  before_.weight_begun += progress_.weight_begun;
  before_.tiles_stored += progress_.tiles_stored - stored_before().size();
  progress_.tiles_begun = progress_.weight_begun = progress_.tiles_stored = 0;
  sum_.sleeps += schedule_.sleeps();
  schedule_ = Schedule(part_->stages.at(table.stage).schedule, {});
  stored_.clear();
  rebirths_ = nullptr;
  totals_ = {};
  said_.forget(ShareEvent::begun);
}

// Checks a table, because a process other than the coordinator may have sent it.
bool ShareActor::is_of_job(const RoutingTable& table, const std::vector<caf::actor>& parts) const {
  const std::size_t tiles = weights().size();
  return table.nodes.size() == tiles && table.incarnations.size() == tiles && table.stage < part_->stages.size() &&
         std::all_of(table.nodes.begin(), table.nodes.end(), [&](NodeId node) { return node.value < parts.size(); });
}

Failure ShareActor::not_of_job() const {
  return failure_of(error(Errc::internal, name_of(self_) + " got a table that is not of its job"));
}

// Returns the weights of the share's own tiles, and 0 for all others.
std::vector<std::uint64_t> ShareActor::weights_by(const RoutingTable& table) const {
  std::vector<std::uint64_t> here = weights();
  for (std::uint32_t t = 0; t < here.size(); ++t) {
    if (table.node_of(TileId{t}) != self_) here[t] = 0;
  }
  return here;
}

// Tiles that are new on this node by the table are added. Tiles that are not on it any more were fresh, and have been
// released.
void ShareActor::go_by(std::shared_ptr<const RoutingTable> table, const std::vector<caf::actor>& parts) {
  auto routes = std::make_shared<Routes>();
  nodes_ = parts.size();
  routes->table = table;
  routes->rebirths = rebirths_;
  for (const caf::actor& part : parts) routes->parts.push_back(caf::actor_cast<ShareHandle>(part));
  for (std::uint32_t t = 0; t < weights().size(); ++t) {
    if (weights()[t] == 0 || table->node_of(TileId{t}) != self_ || hosts(TileId{t})) continue;
    Hosted& hosted = hosted_[TileId{t}];  // first: a tile that exists must be in hosted_, to be told to leave
    hosted.handle =
        spawn<TileActor>(table->peer_of(TileId{t}), part_, std::shared_ptr<const ActorDirectory>(office_), table);
    if (opened()) schedule_.add(TileId{t}, weights()[t]);
  }
  routes->tiles.reserve(hosted_.size());
  for (const auto& [tile, hosted] : hosted_) routes->tiles.emplace_back(tile, hosted.handle);
  office_->set_routes(std::move(routes));
  table_ = std::move(table);
}

void ShareActor::change_table(ChangeTable& change) {
  if (failure_ || !opened() || change.table.epoch <= table_->epoch) return;
  office_->hooks.tell([&] { return name_of(self_) + ": epoch " + to_string(change.table.epoch); });
  if (!is_of_job(change.table, change.parts)) return stop(not_of_job());
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
  for (const ShareEvent word : {ShareEvent::idle, ShareEvent::settled, ShareEvent::collected}) said_.forget(word);
  const bool rejoins = schedule_.mode() == Schedule::Mode::exchanging;
  if (rejoins) rebirths_ = incarnation_changes_between(*table_, change.table, std::move(rebirths_));
  std::vector<TileHandle> before;
  for (const auto& [tile, hosted] : hosted_) before.push_back(hosted.handle);
  go_by(std::make_shared<const RoutingTable>(std::move(change.table)), change.parts);
  close_gates();
  if (rejoins) {
    rejoining_ = static_cast<std::uint32_t>(before.size());
    if (before.empty()) rebirths_ = nullptr;
    for (const TileHandle& tile : before) send(tile, Rejoin{});
  }
  deliver_early();
}

void ShareActor::take(const TileRejoined& rejoined) {
  const auto found = hosted_.find(rejoined.tile);
  if (found == hosted_.end()) return;  // given up since it sent this
  Hosted& tile = found->second;
  note(tile, {rejoined.sent, rejoined.processed});
  const MailNotice& mail = rejoined.waiting;
  schedule_.note_mail(rejoined.tile, {mail.updates, mail.bytes, mail.memory, mail.hops});
  // When two tables follow each other, a tile may say twice that it goes by the second one.
  if (rejoined.epoch == table_->epoch && std::exchange(tile.epoch, rejoined.epoch) != rejoined.epoch) --rejoining_;
  if (rejoining_ == 0) rebirths_ = nullptr;
}

// The mail of released tiles goes with them. Their next incarnations are told all of it again.
void ShareActor::release(const Release& wanted) {
  std::vector<TileId> released;
  const bool can = !failure_ && opened() && rejoining_ == 0 && schedule_.mode() != Schedule::Mode::settling &&
                   schedule_.mode() != Schedule::Mode::handing;
  if (can) released = schedule_.release(wanted.weight);
  for (const TileId tile : released) {
    const auto hosted = hosted_.find(tile);
    send(hosted->second.handle, Leave{true});
    note(hosted->second, {});
    hosted_.erase(hosted);
    given_up_.push_back(tile);
    ++leaving_;
  }
  ++releases_;
  answer_if_left();
}

void ShareActor::take(const TileLeft&) {
  --leaving_;
  answer_if_left();
}

// Tiles that have not begun need nothing: other nodes begin them. A tile that was handed over hears nothing any more,
// and is told again where it goes on. The share may be settling. When another node was lost meanwhile, the job
// exchanges again, but there is no new table before some node takes the tiles of the lost one.
void ShareActor::hand_over() {
  if (failure_ || !opened() || schedule_.mode() > Schedule::Mode::settling) return;
  office_->hooks.tell([&] { return name_of(self_) + ": hands over"; });
  schedule_.enter(Schedule::Mode::handing);
}

// A tile that is about to leave may still write to the scratch that its next incarnation on this node would use. So the
// share answers when all such tiles have left.
void ShareActor::answer_if_left() {
  if (leaving_ > 0) return;
  for (; releases_ > 0; --releases_) tell(ShareReleased{self_, std::exchange(given_up_, {})});
  // A coordinator that takes over then finds no share here. The images say that the tiles were handed over.
  if (!finder_ || schedule_.mode() == Schedule::Mode::handing) return;
  ShareFound answer;
  answer.term = term_;
  answer.node = finder_->node;
  answer.part = caf::actor_cast<caf::actor>(this);
  answer.self = self_;
  answer.begun = opened();
  answer.table = *table_;
  answer.threads = stage().schedule.threads;
  answer.memory_bytes = office_->options.memory_bytes;
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
  releases_ = 0;
  given_up_.clear();
  finder_ = found;
  answer_if_left();
}

// The tiles go on. What they say meanwhile is said again to the coordinator that takes over.
void ShareActor::lost_coordinator(const caf::down_msg& down) {
  if (!coordinator_ || down.source != coordinator_.address()) return;
  coordinator_ = nullptr;
  if (office_->options.grace_s == 0 || failure_) return stop(lost("the coordinator", down.reason));
  delayed_send(this, std::chrono::seconds(office_->options.grace_s), GraceOver{term_});
}

}  // namespace tessera
