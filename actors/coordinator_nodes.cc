// Which nodes a coordinator has: it finds those of one before it, others come, and each has its tiles.
#include <algorithm>
#include <utility>

#include "actors/coordinator.h"
#include "actors/failing.h"

namespace tessera {

void Coordinator::find(const NodeHandle& node) {
  monitor(node);
  send(node, FindPart{options_.job, options_.term, caf::actor_cast<caf::actor>(node), caf::actor_cast<caf::actor>(this),
                      std::max(1U, options_.spec.shares)});
}

void Coordinator::found(PartFound& message) {
  if (state_ != State::finding || message.term != options_.term) return;
  const auto asked = std::find(asked_.begin(), asked_.end(), caf::actor_cast<NodeHandle>(message.node));
  if (asked == asked_.end()) return;
  asked_.erase(asked);
  answers_.push_back(std::move(message));
  if (asked_.empty()) take_over();
}

// The newest table that any part goes by is the last that counted: what came after it was heard by nobody.
void Coordinator::take_over() {
  std::vector<NodeHandle> without;
  std::uint32_t numbers = numbers_lost_;
  for (const PartFound& found : answers_) {
    if (!found.part) {
      without.push_back(caf::actor_cast<NodeHandle>(found.node));
      continue;
    }
    if (found.table.epoch >= table_.epoch) table_ = found.table;
    numbers = std::max(numbers, found.self.value + 1);
  }
  const bool anew = without.size() == answers_.size();
  if (anew && !may_begin()) return;
  without_room_ = false;
  if (!anew) {
    for (const NodeId node : table_.nodes) numbers = std::max(numbers, node.value + 1);
  }
  parts_.resize(numbers);
  for (PartOf& p : parts_) p.lost = p.ended = p.opened = true;
  if (anew) return open_anew();
  for (const PartFound& found : answers_) {
    if (!found.part) continue;
    PartOf& p = parts_[found.self.value];
    p.lost = p.ended = false;
    p.node = caf::actor_cast<NodeHandle>(found.node);
    p.part = caf::actor_cast<PartHandle>(found.part);
    p.threads = found.threads;
    p.memory_bytes = found.memory_bytes;
    p.name = found.name;
    p.begun = found.begun;
    p.abort.message().term = options_.term;
    monitor(p.part);
  }
  go_on();
  answers_.clear();
  for (const NodeHandle& node : without) join(node);
}

// Nobody has anything of it: what is on scratch, or settled, each will find.
void Coordinator::open_anew() {
  state_ = State::opening;
  std::vector<Host> hosts;
  for (const PartFound& found : answers_) {
    hosts.push_back(host(NodeId{static_cast<std::uint32_t>(parts_.size())}, found.threads, found.memory_bytes));
    parts_.emplace_back().node = caf::actor_cast<NodeHandle>(found.node);
  }
  answers_.clear();
  // Others than those of parts that nobody was asked for, and that go on.
  std::uint32_t stage = 0;
  if (options_.first_stage) {
    const auto first = options_.first_stage();
    if (!first) return fail(failure_of(first.error()));
    stage = first.value();
  }
  table_ = {first_epoch(), stage, std::vector<NodeId>(options_.weights.size()),
            std::vector<std::uint32_t>(options_.weights.size(), first_incarnation())};
  const std::vector<NodeId> nodes_of = share_out(options_.order, options_.weights, hosts);
  for (std::size_t i = 0; i < nodes_of.size(); ++i) table_.nodes[options_.order[i].value] = nodes_of[i];
  const SharedBytes spec = spec_bytes();
  for (const Host& host : hosts) prepare(host.node, spec);
  for (PartOf& p : parts_) p.open.say(p.node);
}

void Coordinator::go_on() {
  const auto settled = options_.is_settled(table_.stage);
  if (!settled) return fail(failure_of(settled.error()));
  // Asked after the marker was read: if that was written under a later term, the term had been claimed before. It says
  // nothing of the parts found here, which would store what is not settled.
  if (options_.replaced && options_.replaced()) return step_down();
  // Else the one before it has done so, as in begin().
  if (!settled.value() && std::none_of(parts_.begin(), parts_.end(), [](const PartOf& p) { return p.begun; })) {
    if (Status marked = options_.mark_settled(table_.stage, false); !marked)
      return fail(failure_of(std::move(marked).error()));
  }
  account_.start(std::chrono::steady_clock::now(), settled.value());
  state_ = State::exchanging;
  if (settled.value()) {
    state_ = State::collecting;
    const auto stored = options_.stored(table_.stage);  // by nodes that cannot say so any more, too
    if (!stored) return fail(failure_of(stored.error()));
    for (const TileReceipt& tile : stored.value()) take({table_.stage, tile, 0});
  }
  std::vector<bool> nowhere(options_.weights.size());
  for (const PartFound& found : answers_) {
    for (const TileId t : found.released) nowhere.at(t.value) = table_.node_of(t) == found.self;
  }
  std::vector<TileId> tiles;
  for (const TileId t : options_.order) {
    const bool lost = parts_.at(table_.node_of(t).value).lost || nowhere[t.value];
    if (lost && !stored_[t.value]) tiles.push_back(t);
  }
  const std::vector<Host> there = hosts();
  change_table(there.empty() ? std::vector<Placement>() : again(tiles, there));
  released_ = std::move(tiles);  // there is no room for them; or all that are there are to leave
  const caf::message message = for_parts(beginning());
  for (std::size_t n = 0; n < parts_.size(); ++n) {
    if (!parts_[n].begun && parts_[n].part) tell(parts_[n], message);
  }
  if (settled.value()) tell_parts(Collect{});
  if (!there.empty() && !released_.empty()) wait_for_room(released_, {});
}

void Coordinator::join(const NodeHandle& node) {
  if (state_ == State::finishing || state_ == State::ending || knows(node) || leaves(node)) return;
  if (state_ == State::finding) {
    asked_.push_back(node);
    return find(node);
  }
  parts_.emplace_back().node = node;
  prepare(NodeId{static_cast<std::uint32_t>(parts_.size() - 1)}, spec_bytes());
  parts_.back().open.say(node);
}

// All tiles are fresh, so the work is shared out anew: nodes have come and gone. A tile that stays where it is keeps
// its incarnation: nothing of the stage before is on its way to it.
void Coordinator::begin_next_stage() {
  if (table_.nodes.empty()) {  // one node had all
    table_.nodes.assign(options_.weights.size(), NodeId{0});
    table_.incarnations.assign(options_.weights.size(), 0);
  }
  ++table_.stage;
  if (Status marked = options_.mark_settled(table_.stage, false); !marked) {
    return fail(failure_of(std::move(marked).error()));
  }
  account_.begin_stage(std::chrono::steady_clock::now());
  state_ = State::exchanging;
  stored_.assign(stored_.size(), false);
  for (PartOf& p : parts_) p.begun = false;
  waiting_.clear();
  std::vector<TileId> tiles = options_.order;
  const std::vector<Host> there = hosts();
  std::vector<Placement> changes = there.empty() ? std::vector<Placement>() : again(tiles, there);
  std::erase_if(changes, [&](const Placement& change) { return table_.node_of(change.tile) == change.node; });
  std::erase_if(tiles, [&](TileId tile) { return !there.empty() && !parts_.at(table_.node_of(tile).value).lost; });
  released_ = std::move(tiles);  // there is no room for them; or all that are there are to leave
  change_table(changes);
  if (!there.empty() && !released_.empty()) wait_for_room(released_, {});
}

// Those that it began with are told of, too.
bool Coordinator::knows(const NodeHandle& node) const {
  return std::find(asked_.begin(), asked_.end(), node) != asked_.end() ||
         std::any_of(answers_.begin(), answers_.end(),
                     [&](const PartFound& found) { return caf::actor_cast<NodeHandle>(found.node) == node; }) ||
         std::any_of(parts_.begin(), parts_.end(), [&](const PartOf& p) { return p.node == node; });
}

// A part that has come later. It has no tiles yet, and so nothing to settle.
void Coordinator::welcome(NodeId node) {
  send(parts_.at(node.value).part, beginning());
  detector_.restart(nodes());
  parts_.at(node.value).settled = state_ == State::settling;
  waiting_.push_back(node);
  if (state_ == State::settling) return;
  if (!has_room(node)) return place_orphans();
  std::vector<std::uint64_t> held(parts_.size());
  for (const TileId t : options_.order) held[table_.node_of(t).value] += options_.weights[t.value];
  const std::vector<Host> there = hosts();
  for (const Host& host : there) {
    if (host.node == node) continue;
    releasing_.insert(host.node);
    send(parts_[host.node.value].part, Release{held[host.node.value] / there.size()});
  }
  place_orphans();
}

void Coordinator::take(PartReleased& released) {
  const auto asked = releasing_.find(released.node);
  if (asked == releasing_.end()) return;  // lost meanwhile, and its tiles with it
  releasing_.erase(asked);
  released_.insert(released_.end(), released.tiles.begin(), released.tiles.end());
  place_orphans();
}

// A new epoch. Each part counts as busy until all its tiles go by the table, and then until what they tell again has
// been heard.
void Coordinator::change_table(const std::vector<Placement>& changes) {
  table_ = next_table(table_, std::max(table_.epoch + 1, first_epoch()), changes);
  ChangeTable message{table_, part_handles(), state_ == State::collecting};
  for (PartOf& p : parts_) p.settled = p.collected = false;
  detector_.restart_busy(nodes());
  if (state_ == State::settling) {
    state_ = State::exchanging;
    account_.is_not_quiet();
  }
  tell_parts(std::move(message));
}

std::vector<Host> Coordinator::hosts() const {
  std::vector<Host> hosts;
  for (std::uint32_t n = 0; n < parts_.size(); ++n) {
    const PartOf& p = parts_[n];
    if (p.there() && !leaves(p.node)) hosts.push_back(host(NodeId{n}, p.threads, p.memory_bytes));
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
  for (const PartOf& p : parts_) handles.push_back(caf::actor_cast<caf::actor>(p.part));
  return handles;
}

}  // namespace tessera
