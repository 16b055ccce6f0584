// The nodes of a job: the coordinator finds the shares of an earlier coordinator, new nodes come, and each gets tiles.
#include <algorithm>
#include <utility>

#include "actors/coordinator.h"
#include "actors/failing.h"

namespace tessera {

void Coordinator::find(const NodeHandle& node) {
  monitor(node);
  send(node, FindShare{options_.job, options_.term, caf::actor_cast<caf::actor>(node),
                       caf::actor_cast<caf::actor>(this), std::max(1U, options_.spec.shares)});
}

void Coordinator::found(ShareFound& message) {
  if (!course_.is(At::finding) || message.term != options_.term) return;
  const auto asked = std::find(asked_.begin(), asked_.end(), caf::actor_cast<NodeHandle>(message.node));
  if (asked == asked_.end()) return;
  asked_.erase(asked);
  answers_.push_back(std::move(message));
  if (asked_.empty()) take_over();
}

// The newest table by which any share goes is the last that counted. No share has heard of any later table.
void Coordinator::take_over() {
  std::vector<NodeHandle> without;
  std::uint32_t numbers = numbers_lost_;
  RoutingTable newest = table();
  for (const ShareFound& found : answers_) {
    if (!found.part) {
      without.push_back(caf::actor_cast<NodeHandle>(found.node));
      continue;
    }
    if (found.table.epoch >= newest.epoch) newest = found.table;
    numbers = std::max(numbers, found.self.value + 1);
  }
  const bool anew = without.size() == answers_.size();
  if (anew && !may_begin()) return;
  without_room_ = false;
  if (!anew) {
    for (const NodeId node : newest.nodes) numbers = std::max(numbers, node.value + 1);
  }
  parts_ = std::vector<Participant>(numbers);
  roster_.take_numbers(numbers);
  if (anew) return open_anew();
  placements_.adopt(std::move(newest));
  for (const ShareFound& found : answers_) {
    if (!found.part) continue;
    Participant& p = parts_[found.self.value];
    p.node = caf::actor_cast<NodeHandle>(found.node);
    p.part = caf::actor_cast<ShareHandle>(found.part);
    p.abort.message().term = options_.term;
    Roster::Node& node = roster_[found.self];
    node.standing = Standing::there;
    node.threads = found.threads;
    node.memory_bytes = found.memory_bytes;
    node.name = found.name;
    node.begun = found.begun;
    monitor(p.part);
  }
  go_on();
  answers_.clear();
  for (const NodeHandle& node : without) join(node);
}

// No node has a share of this job. Nodes will find what is on scratch, or settled.
void Coordinator::open_anew() {
  course_.open();
  std::vector<Host> hosts;
  for (const ShareFound& found : answers_) {
    hosts.push_back(host(add(caf::actor_cast<NodeHandle>(found.node)), found.threads, found.memory_bytes));
  }
  answers_.clear();
  std::uint32_t stage = 0;
  if (options_.first_stage) {
    const auto first = options_.first_stage();
    if (!first) return fail(failure_of(first.error()));
    stage = first.value();
  }
  placements_.begin(stage, hosts);
  const SharedBytes spec = spec_bytes();
  for (const Host& host : hosts) prepare(host.node, spec);
  for (Participant& p : parts_) p.open.say(p.node);
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
  std::vector<bool> nowhere(options_.weights.size());
  for (const ShareFound& found : answers_) {
    for (const TileId t : found.released) nowhere.at(t.value) = table().node_of(t) == found.self;
  }
  std::vector<TileId> tiles;
  for (const TileId t : placements_.order()) {
    const bool lost = !roster_.has(table().node_of(t)) || nowhere[t.value];
    if (lost && !placements_.is_stored(t)) tiles.push_back(t);
  }
  placements_.release(tiles);
  const std::vector<Host> there = hosts();  // empty: all nodes that are there are to leave
  change_table(there.empty() ? std::vector<Placement>() : placements_.place(there, lives()).changes);
  const caf::message message = for_parts(beginning());
  for (std::uint32_t n = 0; n < parts_.size(); ++n) {
    if (!roster_[NodeId{n}].begun && parts_[n].part) tell(parts_[n], message);
  }
  if (settled.value()) tell_parts(Collect{});
  if (!there.empty() && !placements_.homeless().empty()) wait_for_room(placements_.homeless());
}

void Coordinator::begin_next_stage() {
  course_.begin_next_stage();
  account_.begin_stage(std::chrono::steady_clock::now());
  roster_.begin_stage();
  const std::vector<Host> there = hosts();
  const std::vector<Placement> changes = placements_.begin_next_stage(there, lives());
  if (Status marked = options_.mark_settled(table().stage, false); !marked)
    return fail(failure_of(std::move(marked).error()));
  change_table(changes);
  if (!there.empty() && !placements_.homeless().empty()) wait_for_room(placements_.homeless());
}

void Coordinator::join(const NodeHandle& node) {
  if (course_.ends() || knows(node) || leaves(node)) return;
  if (course_.is(At::finding)) {
    asked_.push_back(node);
    return find(node);
  }
  prepare(add(node), spec_bytes());
  parts_.back().open.say(node);
}

NodeId Coordinator::add(const NodeHandle& node) {
  parts_.emplace_back().node = node;
  return roster_.add();
}

// Nodes with which the job has begun are told of once more, and are known already.
bool Coordinator::knows(const NodeHandle& node) const {
  return std::find(asked_.begin(), asked_.end(), node) != asked_.end() ||
         std::any_of(answers_.begin(), answers_.end(),
                     [&](const ShareFound& found) { return caf::actor_cast<NodeHandle>(found.node) == node; }) ||
         std::any_of(parts_.begin(), parts_.end(), [&](const Participant& p) { return p.node == node; });
}

// A share that was opened while others work. It has no tiles yet, and so nothing to settle.
void Coordinator::welcome(NodeId node) {
  send(parts_.at(node.value).part, beginning());
  detector_.restart(nodes());
  placements_.come_late(node);
  if (course_.is(At::settling)) {
    roster_[node].reached = Reached::settled;
    return;
  }
  if (!has_room(node)) return place_orphans();
  const std::vector<std::uint64_t> held = placements_.held(parts_.size());
  const std::vector<Host> there = hosts();
  for (const Host& host : there) {
    if (host.node == node) continue;
    placements_.ask(host.node);
    send(parts_[host.node.value].part, Release{held[host.node.value] / there.size()});
  }
  place_orphans();
}

// Sends a table of a new epoch. Each share counts as busy until all its tiles go by the table and what they tell again
// has been processed.
void Coordinator::change_table(const std::vector<Placement>& changes) {
  ChangeTable message{placements_.change(changes), part_handles(), course_.is(At::collecting)};
  roster_.forget_reached();
  detector_.restart_busy(nodes());
  is_disturbed();
  tell_parts(std::move(message));
}

// Some tiles begin again, or go on elsewhere.
void Coordinator::is_disturbed() {
  if (course_.disturb()) account_.is_not_quiet();
}

std::vector<Host> Coordinator::hosts() const {
  std::vector<Host> hosts;
  for (std::uint32_t n = 0; n < parts_.size(); ++n) {
    const Roster::Node& node = roster_[NodeId{n}];
    if (node.there() && !leaves(parts_[n].node)) hosts.push_back(host(NodeId{n}, node.threads, node.memory_bytes));
  }
  return hosts;
}

std::set<NodeId> Coordinator::nodes() const {
  std::set<NodeId> nodes;
  for (const Host& host : hosts()) nodes.insert(host.node);
  return nodes;
}

std::vector<caf::actor> Coordinator::part_handles() const {
  std::vector<caf::actor> handles;
  for (const Participant& p : parts_) handles.push_back(caf::actor_cast<caf::actor>(p.part));
  return handles;
}

}  // namespace tessera
