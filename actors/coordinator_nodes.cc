// The nodes of a job: the coordinator finds the shares of an earlier coordinator; nodes come, leave and are lost; and
// each tile has a node, or waits for one.
#include <algorithm>
#include <utility>

#include "actors/coordinator.h"
#include "actors/failing.h"
#include "src/exchange/leaving.h"

namespace tessera {
namespace {

std::string gone(const caf::down_msg& down) { return "does not answer any more: " + in_words(down.reason); }

}  // namespace

// Returns the question to the node for which `is` holds, unless that node was lost.
template <class Is>
std::optional<Inquiry::Question> Coordinator::question_to(Is is) const {
  for (Inquiry::Question q = 0; q < asked_.size(); ++q) {
    if (is(asked_[q].node) && (inquiry_.is_open(q) || inquiry_.is_answered(q))) return q;
  }
  return std::nullopt;
}

void Coordinator::ask(const NodeHandle& node) {
  asked_.push_back({node, {}});
  inquiry_.ask();
}

void Coordinator::find(const NodeHandle& node) {
  monitor(node);
  send(node, FindShare{options_.job, options_.term, caf::actor_cast<caf::actor>(node),
                       caf::actor_cast<caf::actor>(this), std::max(1U, options_.spec.shares)});
}

void Coordinator::found(ShareFound& message) {
  if (!course_.is(At::finding) || message.term != options_.term) return;
  const auto node = caf::actor_cast<NodeHandle>(message.node);
  const auto question = question_to([&](const NodeHandle& asked) { return asked == node; });
  if (!question || !inquiry_.is_open(*question)) return;
  asked_[*question].share = caf::actor_cast<ShareHandle>(message.share);
  inquiry_.take(*question,
                {message.share != nullptr, message.self, message.begun, std::move(message.table),
                 std::move(message.released), message.threads, message.memory_bytes, std::move(message.name)});
  if (!inquiry_.waits()) take_over();
}

// The newest table by which any share goes is the last that counted.
void Coordinator::take_over() {
  std::optional<RoutingTable> newest = inquiry_.newest(table());
  if (!newest) {
    std::vector<Host> hosts;
    for (const auto& [question, answer] : inquiry_.answers())
      hosts.push_back(room_.host(NodeId{0}, answer.threads, answer.memory_bytes));
    const std::vector<TileId> without = NodeRoom::without(hosts, placements_);
    if (!without.empty()) return wait_for_room(without);
  }
  wait_.has_room();
  const std::uint32_t numbers = inquiry_.numbers(newest);
  participants_ = std::vector<Participant>(numbers);
  roster_.take_numbers(numbers);
  if (!newest) return open_anew();
  placements_.adopt(std::move(*newest));
  std::vector<NodeHandle> without;
  for (const auto& [question, answer] : inquiry_.answers()) {
    const Asked& asked = asked_[question];
    if (!answer.has_share) {
      without.push_back(asked.node);
      continue;
    }
    Participant& p = participants_[answer.self.value];
    p.node = asked.node;
    p.share = asked.share;
    p.abort.message().term = options_.term;
    roster_.find(answer.self, answer.begun, {answer.threads, answer.memory_bytes, answer.name});
    monitor(p.share);
  }
  go_on();
  forget_inquiry();
  for (const NodeHandle& node : without) join(node);
}

void Coordinator::forget_inquiry() {
  inquiry_ = Inquiry();
  asked_.clear();
}

// No node has a share of this job. Nodes will find what is on scratch, or settled.
void Coordinator::open_anew() {
  course_.open();
  std::vector<Host> hosts;
  for (const auto& [question, answer] : inquiry_.answers())
    hosts.push_back(room_.host(add(asked_[question].node), answer.threads, answer.memory_bytes));
  forget_inquiry();
  std::uint32_t stage = 0;
  if (options_.first_stage) {
    const auto first = options_.first_stage();
    if (!first) return fail(failure_of(first.error()));
    stage = first.value();
  }
  placements_.begin(stage, hosts);
  const SharedBytes spec = spec_bytes();
  for (const Host& host : hosts) prepare(host.node, spec);
  for (Participant& p : participants_) p.open.say(p.node);
}

void Coordinator::go_on() {
  const auto settled = options_.is_settled(table().stage);
  if (!settled) return fail(failure_of(settled.error()));
  // Asked after the marker was read. If another coordinator has written the marker, it had claimed its term before
  // that. Such a marker says nothing of the shares found here, which would store what is not settled.
  if (options_.replaced && options_.replaced()) return step_down();
  // Otherwise the coordinator before has done this, as in begin().
  if (!settled.value() && !roster_.any_has_begun()) {
    if (Status marked = options_.mark_settled(table().stage, false); !marked)
      return fail(failure_of(std::move(marked).error()));
  }
  account_.start(std::chrono::steady_clock::now(), settled.value());
  course_.begin(settled.value());
  if (settled.value()) {
    const auto stored = options_.stored(table().stage);  // also by nodes that are gone and cannot say so
    if (!stored) return fail(failure_of(stored.error()));
    for (const TileReceipt& tile : stored.value()) take({table().stage, tile, 0});
  }
  placements_.release_homeless(lives(), inquiry_.given_up(table(), options_.weights.size()));
  const std::vector<Host> there = hosts();  // empty: all nodes that are there are to leave
  change_table(there.empty() ? std::vector<Placement>() : placements_.place(there, lives()).changes);
  const caf::message message = for_shares(beginning());
  for (std::uint32_t n = 0; n < participants_.size(); ++n) {
    if (!roster_[NodeId{n}].begun && participants_[n].share) tell(participants_[n], message);
  }
  if (settled.value()) tell_shares(Collect{});
  if (!there.empty() && !placements_.homeless().empty()) wait_for_room(placements_.homeless());
}

void Coordinator::join(const NodeHandle& node) {
  if (course_.ends() || knows(node) || leaves(node)) return;
  if (course_.is(At::finding)) {
    ask(node);
    return find(node);
  }
  prepare(add(node), spec_bytes());
  participants_.back().open.say(node);
}

NodeId Coordinator::add(const NodeHandle& node) {
  participants_.emplace_back().node = node;
  return roster_.add();
}

// Nodes with which the job has begun are told of once more, and are known already.
bool Coordinator::knows(const NodeHandle& node) const {
  return question_to([&](const NodeHandle& asked) { return asked == node; }) ||
         std::any_of(participants_.begin(), participants_.end(), [&](const Participant& p) { return p.node == node; });
}

void Coordinator::prepare(NodeId node, const SharedBytes& spec) {
  Participant& p = participants_[node.value];
  monitor(p.node);
  p.open.message() = {options_.job, node, spec, caf::actor_cast<caf::actor>(this), options_.term};
  p.abort.message().term = options_.term;
}

SharedBytes Coordinator::spec_bytes() const {
  ShareSpec spec = options_.spec;
  spec.table = table();
  return to_bytes(spec);
}

void Coordinator::opened(const ShareOpened& message) {
  Participant& p = participants_.at(message.node.value);
  Roster::Node& node = roster_[message.node];
  if (message.failure) return not_opened(message);
  account_.node_came();
  roster_.open(message.node, message.settled, {message.threads, message.memory_bytes, message.name});
  p.share = caf::actor_cast<ShareHandle>(message.share);
  if (course_.is(At::finishing)) node.standing = Standing::left;  // the share is not needed any more
  if (node.gone() || course_.is(At::ending)) {
    p.abort.say(p.share);
    return finish_if_over();
  }
  monitor(p.share);
  if (course_.is(At::opening)) return begin_if_opened();
  if (!node.name.empty()) owner_.said("node " + node.name + " now works on the job");
  welcome(message.node);
}

// The job goes on without the node, if there are others. A job that no node can open, though none was lost, fails.
void Coordinator::not_opened(const ShareOpened& message) {
  roster_[message.node].standing = Standing::refused;
  if (course_.ends()) return finish_if_over();
  if (roster_.all_refused() && !wait_.has_waited()) return fail(message.failure);
  owner_.said((message.name.empty() ? "a node" : "node " + message.name) +
              " cannot work on the job: " + message.failure.text);
  if (nobody()) return wait_for_a_node(message.failure);
  if (course_.is(At::opening)) begin_if_opened();
}

// A share that was opened while others work. It has no tiles yet, and so nothing to settle.
void Coordinator::welcome(NodeId node) {
  send(participants_.at(node.value).share, beginning());
  detector_.restart(nodes());
  placements_.come_late(node);
  if (course_.is(At::settling)) {
    roster_[node].reached = Reached::settled;
    return;
  }
  const Host newcomer = room_.host(node, roster_[node].threads, roster_[node].memory_bytes);
  if (!NodeRoom::has_any(newcomer, placements_)) return place_homeless();
  for (const Placements::Request& request : placements_.ask_for(node, hosts()))
    send(participants_[request.node.value].share, Release{request.weight});
  place_homeless();
}

// `back` tells of a new process of a node. Says so in the job's log when the node has had a share of the job.
void Coordinator::note(const NodeBack& back) {
  if (roster_.knows(back.name)) owner_.said("node " + back.name + ": the process before this one " + back.last_words);
}

void Coordinator::leave(const NodeLeaves& leaves) {
  const auto node = caf::actor_cast<NodeHandle>(leaves.node);
  if (course_.is(At::finding)) join(node);
  leaving_.push_back({node, caf::actor_cast<UsherHandle>(leaves.registry)});
}

bool Coordinator::leaves(const NodeHandle& node) const {
  return std::any_of(leaving_.begin(), leaving_.end(), [&](const Leaving& one) { return one.node == node; });
}

// Called after every step, because each step may bring the job to where nodes can go.
void Coordinator::let_go() {
  for (std::size_t i = 0; i < leaving_.size() && !told_;) {
    if (!may_go(leaving_[i].node)) {
      ++i;
      continue;
    }
    const Leaving one = leaving_[i];
    leaving_.erase(leaving_.begin() + static_cast<std::ptrdiff_t>(i));
    send(one.registry, NodeLet{caf::actor_cast<caf::actor>(one.node), caf::actor_cast<caf::actor>(this)});
  }
}

bool Coordinator::may_go(const NodeHandle& node) {
  if (course_.is(At::finding)) return !knows(node);
  NodeId number;
  while (number.value < participants_.size() && (participants_[number.value].node != node || roster_[number].over()))
    ++number.value;
  if (number.value == participants_.size()) return true;
  const ShareHandle& share = participants_[number.value].share;
  switch (next_leave_step(course_, roster_, placements_, number)) {
    case LeaveStep::dismiss:
      dismiss(number);
      return true;
    case LeaveStep::hand_over:
      send(share, HandOver{});
      break;
    case LeaveStep::finish:
      send(share, Finish{});
      break;
    case LeaveStep::wait:
      break;
  }
  return false;
}

// The node's share has begun nothing.
void Coordinator::dismiss(NodeId node) {
  Participant& p = participants_[node.value];
  roster_[node].standing = Standing::left;
  if (p.share) {
    demonitor(p.share.address());
    p.abort.say(p.share);
    p.share = nullptr;
  }
  if (nobody()) return wait_for_a_node(failure_of(error(Errc::internal, "the last node has left")));
  if (course_.is(At::opening)) begin_if_opened();
}

// The share has handed over its tiles, or has stored them.
void Coordinator::left(const ShareEnded& message) {
  Roster::Node& node = roster_[message.node];
  node.standing = Standing::left;
  if (placements_.end_handing(message.node)) account_.tiles_begin_again(message.not_handed);
  if (!node.name.empty()) {
    owner_.said("node " + node.name + " leaves: other nodes continue " + std::to_string(message.handed) +
                " tiles that it had begun" +
                (message.not_handed == 0 ? "" : "; " + std::to_string(message.not_handed) + " tiles begin again"));
  }
  detector_.restart(nodes());
  if (nobody()) return wait_for_a_node(failure_of(error(Errc::internal, "the last node has left")));
  place_homeless();
}

void Coordinator::lost_actor(const caf::down_msg& down) {
  const auto asked = question_to([&](const NodeHandle& node) { return node.address() == down.source; });
  if (asked && inquiry_.is_open(*asked))
    return lose(NodeHandle(asked_[*asked].node), lost("a node", down.reason), gone(down));
  for (std::uint32_t n = 0; n < participants_.size(); ++n) {
    const Participant& p = participants_[n];
    const bool node = p.node && down.source == p.node.address();
    const bool share = p.share && down.source == p.share.address();
    if ((!node && !share) || roster_[NodeId{n}].over()) continue;
    if (node && roster_[NodeId{n}].there()) continue;  // its share lives on, or will be missed by itself
    return lose(NodeId{n}, lost(node ? "a node" : "a node's share of the job", down.reason), gone(down));
  }
}

void Coordinator::lose(const NodeHandle& node, Failure failure, const std::string& why) {
  if (course_.is(At::finding)) return lose_found(node);
  for (std::uint32_t n = 0; n < participants_.size(); ++n) {
    if (participants_[n].node == node) return lose(NodeId{n}, std::move(failure), why);
  }
}

void Coordinator::lose(NodeId node, Failure failure, const std::string& why) {
  if (roster_[node].over()) return;
  Participant& p = participants_[node.value];
  roster_[node].standing = Standing::lost;
  if (p.share) {
    account_.node_lost();
    demonitor(p.share.address());
  }
  p.share = nullptr;
  missing(node, std::move(failure), why);
}

// A node is lost while shares are looked for, before or after it has answered.
void Coordinator::lose_found(const NodeHandle& node) {
  const auto question = question_to([&](const NodeHandle& asked) { return asked == node; });
  const Inquiry::Lost lost = question ? inquiry_.lose(*question) : Inquiry::Lost::nothing;
  if (lost != Inquiry::Lost::nothing) wait_.note_loss();
  if (lost != Inquiry::Lost::nothing && nobody())
    return wait_for_a_node(failure_of(error(Errc::internal, "the last node is lost")));
  if (!inquiry_.waits() && (lost == Inquiry::Lost::question || wait_.without_room())) {
    wait_.has_room();
    take_over();
  }
}

// The node has no share any more.
void Coordinator::missing(NodeId node, Failure failure, const std::string& why) {
  if (course_.ends()) return finish_if_over();
  if (!course_.is(At::opening)) lose_tiles(node, why);
  if (nobody()) return wait_for_a_node(std::move(failure));
  if (course_.is(At::opening)) return begin_if_opened();
  place_homeless();
}

void Coordinator::lose_tiles(NodeId node, const std::string& why) {
  const std::size_t tiles = placements_.lose(node);
  if (const std::string& name = roster_[node].name; !name.empty()) {
    owner_.said("node " + name + " is lost" + (why.empty() ? "" : ": it " + why) + "; " + std::to_string(tiles) +
                " tiles begin again on other nodes");
  }
  // Nothing that the node has said, or still says, counts, even while there is no other node that takes the tiles.
  detector_.restart(nodes());
  if (tiles > 0) is_disturbed();
}

// Places all homeless tiles at once, when all of them are known. Until then nothing is believed quiet, or finished.
void Coordinator::place_homeless() {
  const std::vector<Host> there = hosts();
  if (placements_.awaits() || there.empty()) return;  // a share that is being opened will take the tiles
  const Placements::Placed placed = placements_.place(there, lives());
  account_.tiles_begin_again(placed.again);
  if (placements_.homeless().empty()) {
    wait_.has_room();
  } else {
    wait_for_room(placements_.homeless());
  }
  if (!placed.changes.empty()) return change_table(placed.changes);
  if (course_.is(At::exchanging)) {
    detector_.restart(nodes());
    act(detector_.look());
  }
  // A node that is lost without tiles may have been the last one that was waited for.
  collect_if_settled();
  finish_if_collected();
}

bool Coordinator::nobody() const { return course_.is(At::finding) ? inquiry_.nobody() : roster_.nobody(); }

// The process of the lost node may come again, and others may be on their way. `failure` is told when none comes.
void Coordinator::wait_for_a_node(Failure failure, const std::string& because) {
  const std::uint32_t patience_s = options_.spec.grace_s;
  if (patience_s == 0) return fail(std::move(failure));
  owner_.said(because + ": the job waits " + std::to_string(patience_s) + " s for another node");
  const std::uint64_t wait = wait_.begin(error_of(std::move(failure)));
  delayed_send(this, std::chrono::seconds(patience_s), NobodyCame{wait});
}

// A tile goes to a node that has the memory for it. While no node has, the job waits for one.
void Coordinator::wait_for_room(const std::vector<TileId>& tiles) {
  if (!wait_.begin_without_room()) return;
  std::vector<NodeRoom::Named> nodes;
  if (course_.is(At::finding)) {  // no node has a share yet
    for (const auto& [question, answer] : inquiry_.answers()) nodes.push_back({answer.name, answer.memory_bytes});
  }
  for (const Roster::Node& node : roster_.nodes()) {
    if (node.there()) nodes.push_back({node.name, node.memory_bytes});
  }
  const std::string because = room_.why_none(tiles, placements_, nodes);
  wait_for_a_node(failure_of(error(Errc::memory, because + "; use smaller tiles, or a node with more memory")),
                  because);
}

void Coordinator::give_up_waiting(const NobodyCame& over) {
  if (course_.ends()) return;
  if (std::optional<Error> missed = wait_.time_is_up(over.wait, nobody())) fail(failure_of(std::move(*missed)));
}

}  // namespace tessera
