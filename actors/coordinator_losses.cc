// Nodes that a coordinator has lost: their tiles begin again on the others; when there is none, it waits for one.
#include <algorithm>
#include <iterator>
#include <utility>

#include "actors/coordinator.h"
#include "actors/failing.h"

namespace tessera {
namespace {

std::string gone(const caf::down_msg& down) { return "does not answer any more: " + in_words(down.reason); }

}  // namespace

void Coordinator::lose(const NodeHandle& node, Failure failure, const std::string& why) {
  if (state_ == State::finding) return lose_found(node);
  for (std::uint32_t n = 0; n < parts_.size(); ++n) {
    if (parts_[n].node == node) return lose(NodeId{n}, std::move(failure), why);
  }
}

// Whether it has answered or not. If it has, its part may still speak, so nobody else gets its number.
void Coordinator::lose_found(const NodeHandle& node) {
  const bool asked = std::erase(asked_, node) > 0;
  const auto answered = std::erase_if(answers_, [&](const PartFound& found) {
    if (caf::actor_cast<NodeHandle>(found.node) != node) return false;
    if (found.part) numbers_lost_ = std::max(numbers_lost_, found.self.value + 1);
    return true;
  });
  if (asked || answered > 0) ++waits_;  // whoever is left may be one that cannot open its part: others are to come
  if ((asked || answered > 0) && nobody())
    return wait_for_a_node(failure_of(error(Errc::internal, "the last node is lost")));
  if (asked_.empty() && (asked || without_room_)) {
    without_room_ = false;
    take_over();
  }
}

void Coordinator::lose(NodeId node, Failure failure, const std::string& why) {
  PartOf& p = parts_.at(node.value);
  if (p.ended) return;
  p.lost = p.ended = true;
  if (p.part) {
    account_.node_lost();
    demonitor(p.part.address());
  }
  p.part = nullptr;
  missing(node, std::move(failure), why);
}

// It takes no part any more.
void Coordinator::missing(NodeId node, Failure failure, const std::string& why) {
  if (state_ == State::finishing || state_ == State::ending) return finish_if_over();
  releasing_.erase(node);
  handing_.erase(node);
  if (state_ != State::opening) orphan_tiles(node, why);
  if (nobody()) return wait_for_a_node(std::move(failure));
  if (state_ == State::opening) return begin_if_opened();
  place_orphans();
}

void Coordinator::orphan_tiles(NodeId node, const std::string& why) {
  const std::size_t before = lost_.size();
  for (const TileId t : options_.order) {
    if (table_.node_of(t) == node && !stored_[t.value]) lost_.push_back(t);
  }
  const PartOf& p = parts_[node.value];
  if (!p.name.empty()) {
    owner_.said("node " + p.name + " is lost" + (why.empty() ? "" : ": it " + why) + "; " +
                std::to_string(lost_.size() - before) + " tiles begin again on others");
  }
  // Of what it has said, or says still, nothing counts, also while no other node is there that takes the tiles.
  detector_.restart(nodes());
  if (state_ == State::settling && !lost_.empty()) {
    state_ = State::exchanging;
    account_.is_not_quiet();
  }
}

// Others do without it, if there are any. What nobody can open, and nobody was lost, is not waited for.
void Coordinator::not_opened(const PartOpened& message) {
  PartOf& p = parts_.at(message.node.value);
  p.lost = p.ended = p.refused = true;
  if (state_ == State::finishing || state_ == State::ending) return finish_if_over();
  const bool by_all = std::all_of(parts_.begin(), parts_.end(), [](const PartOf& part) { return part.refused; });
  if (by_all && waits_ == 0) return fail(message.failure);
  owner_.said((message.name.empty() ? "a node" : "node " + message.name) +
              " cannot take part: " + message.failure.text);
  if (nobody()) return wait_for_a_node(message.failure);
  if (state_ == State::opening) begin_if_opened();
}

// No part is there, and none is on its way.
bool Coordinator::nobody() const {
  return state_ == State::finding ? asked_.empty() && answers_.empty() : all([](const PartOf&) { return false; });
}

// Its process may come again, and others may be on their way. `failure`: to be told when none comes.
void Coordinator::wait_for_a_node(Failure failure, const std::string& because) {
  const std::uint32_t patience_s = options_.spec.grace_s;
  if (patience_s == 0) return fail(std::move(failure));
  missed_ = std::move(failure);
  owner_.said(because + ": the job waits " + std::to_string(patience_s) + " s for another one");
  delayed_send(this, std::chrono::seconds(patience_s), NobodyCame{++waits_});
}

void Coordinator::give_up_waiting(const NobodyCame& over) {
  const bool waits = over.wait == waits_ && state_ != State::finishing && state_ != State::ending;
  if (waits && (nobody() || without_room_)) fail(std::move(missed_));
}

void Coordinator::lost_actor(const caf::down_msg& down) {
  const auto asked =
      std::find_if(asked_.begin(), asked_.end(), [&](const NodeHandle& node) { return node.address() == down.source; });
  if (asked != asked_.end()) return lose(NodeHandle(*asked), lost("a node", down.reason), gone(down));
  for (std::uint32_t n = 0; n < parts_.size(); ++n) {
    const PartOf& p = parts_[n];
    const bool node = p.node && down.source == p.node.address();
    const bool part = p.part && down.source == p.part.address();
    if ((!node && !part) || p.ended) continue;
    if (node && p.opened) continue;  // its part lives on, or will be missed by itself
    return lose(NodeId{n}, lost(node ? "a node" : "a node's part of the job", down.reason), gone(down));
  }
}

// All at once, when it is known which there are. Until then nothing is believed quiet, or finished.
void Coordinator::place_orphans() {
  const std::vector<Host> all = hosts();
  if (!releasing_.empty() || !handing_.empty() || all.empty()) return;  // a part that is being opened will take them
  std::vector<Host> late;
  std::copy_if(all.begin(), all.end(), std::back_inserter(late), [&](const Host& host) {
    return std::find(waiting_.begin(), waiting_.end(), host.node) != waiting_.end();
  });
  waiting_.clear();
  std::vector<Placement> changes = again(lost_, all);
  account_.tiles_begin_again(changes.size());
  auto moved = again(released_, late, false);
  changes.insert(changes.end(), moved.begin(), moved.end());
  moved = again(released_, all);  // what whoever is late has no room for
  changes.insert(changes.end(), moved.begin(), moved.end());
  if (!lost_.empty() || !released_.empty()) {
    wait_for_room(lost_.empty() ? released_ : lost_, {});
  } else {
    without_room_ = false;
  }
  if (!changes.empty()) return change_table(changes);
  if (state_ == State::exchanging) {
    detector_.restart(nodes());
    act(detector_.look());
  }
  // Whoever is lost without tiles may have been the last that was waited for.
  collect_if_settled();
  finish_if_collected();
}

}  // namespace tessera
