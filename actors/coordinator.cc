#include "actors/coordinator.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "actors/failing.h"

namespace tessera {
namespace {

std::uint64_t microseconds(std::chrono::steady_clock::duration time) {
  return static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::microseconds>(time).count());
}

}  // namespace

Coordinator::Coordinator(caf::actor_config& config, CoordinatorOptions options, RunOwner& owner,
                         std::vector<NodeHandle> nodes)
    : SteadyActor(config),
      options_(std::move(options)),
      owner_(owner),
      detector_({}),
      table_(options_.spec.table),
      stored_(options_.points.size()) {
  live_at(options_.home);
  if (options_.take_over) {
    state_ = State::finding;
    asked_ = std::move(nodes);
  } else {
    for (NodeHandle& node : nodes) parts_.emplace_back().node = std::move(node);
  }
}

// All nodes are asked or none: what is opened must be told how it ends.
void Coordinator::initialize() {
  SteadyActor::initialize();
  for (PartOf& p : parts_) p.open.say(p.node);
  for (const NodeHandle& node : asked_) find(node);
}

// Coordinator and parts know each other: one that has ended must not keep the others alive.
void Coordinator::on_exit() {
  if (!std::exchange(told_, true)) {
    abort_parts();
    RunEnded end;
    end.failure = failure_ ? std::move(*failure_) : ended_unexpectedly();
    owner_.ended(std::move(end));
  }
  for (const PartOf& p : parts_) demonitor(p.node.address());
  parts_.clear();
}

void Coordinator::failed(const std::exception_ptr& exception) noexcept {
  if (!failure_) failure_ = failure_of(exception, [] { return std::string("the coordinator"); });
}

template <class Step>
void Coordinator::attempt(Step step) noexcept {
  try {
    step();
  } catch (...) {
    give_up(failure_of(std::current_exception(), [] { return std::string("the coordinator"); }));
  }
}

template <class Message>
void Coordinator::tell_parts(const Message& message) {
  for (const PartOf& p : parts_) {
    if (p.part) send(p.part, message);
  }
}

template <class Done>
bool Coordinator::all(Done done) const {
  return std::all_of(parts_.begin(), parts_.end(), [&](const PartOf& p) { return p.lost || done(p); });
}

Coordinator::behavior_type Coordinator::make_behavior() {
  set_down_handler([this](caf::scheduled_actor*, caf::down_msg& down) { attempt([&] { lost_actor(down); }); });
  set_error_handler([this](caf::scheduled_actor*, caf::error& reason) {
    attempt([&] { fail(lost("a message of the coordinator", reason)); });
  });
  for (std::size_t n = 0; n < parts_.size(); ++n) prepare(NodeId{static_cast<std::uint32_t>(n)});
  return {
      [this](const PartOpened& message) { attempt([&] { opened(message); }); },
      [this](PartFound& message) { attempt([&] { found(message); }); },
      [this](const PartBegun& message) {
        if (state_ == State::finding) return;
        parts_.at(message.node.value).begun = true;
        if (!begun_ && all([](const PartOf& p) { return p.begun || !p.opened; }))
          begun_ = std::chrono::steady_clock::now();
      },
      [this](const PartIdle&) {
        attempt([&] {
          if (state_ == State::exchanging) act(detector_.notice());
        });
      },
      [this](const PartTally& tally) {
        attempt([&] {
          if (state_ != State::exchanging || tally.epoch != table_.epoch || !releasing_.empty()) return;
          act(detector_.answer(tally.wave, tally.node, tally.idle, {tally.sent, tally.processed}));
        });
      },
      [this](const PartSettled& message) {
        attempt([&] {
          if (message.epoch != table_.epoch || state_ != State::settling) return;
          parts_.at(message.node.value).settled = true;
          if (all([](const PartOf& p) { return p.settled || !p.opened; })) collect();
        });
      },
      [this](const PartCollected& message) {
        attempt([&] {
          if (message.epoch != table_.epoch || state_ != State::collecting) return;
          parts_.at(message.node.value).collected = true;
          finish_if_collected();
        });
      },
      [this](PartReleased& released) {
        attempt([&] {
          if (state_ != State::finding) take(released);
        });
      },
      [this](const NodeLost& lost) {
        attempt([&] {
          lose(caf::actor_cast<NodeHandle>(lost.node), failure_of(error(Errc::internal, "the last node is lost")));
        });
      },
      [this](const NodeJoined& joined) { attempt([&] { join(caf::actor_cast<NodeHandle>(joined.node)); }); },
      [this](PartProgress& message) { attempt([&] { show_progress(message); }); },
      [this](const TileDone& done) { attempt([&] { take(done); }); },
      [this](PartEnded& message) { attempt([&] { ended(message); }); },
      [this](const Cancel&) {
        if (state_ != State::ending) attempt([&] { fail(failure_of(error(Errc::interrupted, "interrupted"))); });
      },
  };
}

void Coordinator::prepare(NodeId node) {
  PartOf& p = parts_[node.value];
  monitor(p.node);
  PartSpec spec = options_.spec;
  spec.table = table_;
  p.open.message() = {options_.job, node, to_bytes(spec), caf::actor_cast<caf::actor>(this), options_.term};
  p.abort.message().term = options_.term;
}

void Coordinator::opened(const PartOpened& message) {
  PartOf& p = parts_.at(message.node.value);
  p.opened = true;
  if (message.failure) {
    const bool needed = !p.lost && state_ == State::opening;  // later ones only help
    p.lost = !needed;
    p.ended = true;
    return needed ? fail(message.failure) : finish_if_over();
  }
  p.settled = message.settled;
  p.threads = message.threads;
  p.part = caf::actor_cast<PartHandle>(message.part);
  if (state_ == State::finishing) p.lost = p.ended = true;  // it is not needed any more
  if (p.lost || state_ == State::ending) {
    p.abort.say(p.part);
    return finish_if_over();
  }
  monitor(p.part);
  if (state_ == State::opening) return begin_if_opened();
  welcome(message.node);
}

void Coordinator::find(const NodeHandle& node) {
  monitor(node);
  send(node,
       FindPart{options_.job, options_.term, caf::actor_cast<caf::actor>(node), caf::actor_cast<caf::actor>(this)});
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
  std::uint32_t numbers = 0;
  for (const PartFound& found : answers_) {
    if (!found.part) {
      without.push_back(caf::actor_cast<NodeHandle>(found.node));
      continue;
    }
    if (found.table.epoch >= table_.epoch) table_ = found.table;
    numbers = std::max(numbers, found.self.value + 1);
  }
  if (numbers == 0) return open_anew(std::move(without));
  for (const NodeId node : table_.nodes) numbers = std::max(numbers, node.value + 1);
  parts_.resize(numbers);
  for (PartOf& p : parts_) p.lost = p.ended = p.opened = true;
  for (const PartFound& found : answers_) {
    if (!found.part) continue;
    PartOf& p = parts_[found.self.value];
    p.lost = p.ended = false;
    p.node = caf::actor_cast<NodeHandle>(found.node);
    p.part = caf::actor_cast<PartHandle>(found.part);
    p.threads = found.threads;
    p.begun = found.begun;
    p.abort.message().term = options_.term;
    monitor(p.part);
  }
  go_on();
  for (const NodeHandle& node : without) join(node);
}

// Nobody has anything of it: what is on scratch, or settled, each will find.
void Coordinator::open_anew(std::vector<NodeHandle> nodes) {
  state_ = State::opening;
  std::vector<Host> hosts;
  for (NodeHandle& node : nodes) {
    hosts.push_back({NodeId{static_cast<std::uint32_t>(parts_.size())}, 1});
    parts_.emplace_back().node = std::move(node);
  }
  if (hosts.empty()) return fail(failure_of(error(Errc::internal, "there is no node")));
  table_ = {table_.epoch, std::vector<NodeId>(options_.points.size()),
            std::vector<std::uint32_t>(options_.points.size())};
  const std::vector<NodeId> nodes_of = share_out(options_.order, options_.points, hosts);
  for (std::size_t i = 0; i < nodes_of.size(); ++i) table_.nodes[options_.order[i].value] = nodes_of[i];
  for (const Host& host : hosts) prepare(host.node);
  for (PartOf& p : parts_) p.open.say(p.node);
}

void Coordinator::go_on() {
  const auto settled = options_.is_settled();
  if (!settled) return fail(failure_of(settled.error()));
  started_ = std::chrono::steady_clock::now();
  state_ = State::exchanging;
  if (settled.value()) {
    state_ = State::collecting;
    begun_ = quiet_ = started_;
    const auto stored = options_.stored();  // by nodes that cannot say so any more, too
    if (!stored) return fail(failure_of(stored.error()));
    for (const TileEntry& entry : stored.value()) take({entry, 0});
  }
  std::vector<TileId> tiles;
  for (const TileId t : options_.order) {
    if (parts_.at(table_.node_of(t).value).lost && !stored_[t.value]) tiles.push_back(t);
  }
  std::vector<bool> begun;
  for (const PartOf& p : parts_) begun.push_back(p.begun);
  change_table(place_again(table_, tiles, options_.points, hosts()));
  for (std::size_t n = 0; n < parts_.size(); ++n) {
    if (!begun[n] && parts_[n].part) begin(NodeId{static_cast<std::uint32_t>(n)});
  }
  if (settled.value()) tell_parts(Collect{});
}

// REQUIRES: the part is open, and has not been told.
void Coordinator::begin(NodeId node) {
  BeginPart message;
  message.settled = state_ == State::collecting;
  message.table = table_;
  message.parts = part_handles();
  send(parts_.at(node.value).part, std::move(message));
}

void Coordinator::take(const TileDone& done) {
  if (stored_.at(done.entry.tile.value)) return;  // by a node that was lost, too
  stored_[done.entry.tile.value] = true;
  owner_.stored(done);
}

void Coordinator::begin_if_opened() {
  if (all([](const PartOf& p) { return p.opened; })) begin();
}

void Coordinator::begin() {
  const bool settled = all([](const PartOf& p) { return p.settled; });
  if (!settled) {
    if (Status marked = options_.mark_settled(false); !marked) return fail(failure_of(std::move(marked).error()));
  }
  started_ = std::chrono::steady_clock::now();
  state_ = settled ? State::collecting : State::exchanging;
  if (settled) begun_ = quiet_ = started_;
  for (const Host& host : hosts()) begin(host.node);
  detector_.restart(nodes());
  for (const TileId t : options_.order) {  // of nodes that were lost before anything began
    if (parts_.at(table_.node_of(t).value).lost) lost_.push_back(t);
  }
  if (!lost_.empty()) place_orphans();
}

std::vector<caf::actor> Coordinator::part_handles() const {
  std::vector<caf::actor> handles;
  for (const PartOf& p : parts_) handles.push_back(caf::actor_cast<caf::actor>(p.part));
  return handles;
}

std::vector<Host> Coordinator::hosts() const {
  std::vector<Host> hosts;
  for (std::uint32_t n = 0; n < parts_.size(); ++n) {
    if (parts_[n].there()) hosts.push_back({NodeId{n}, parts_[n].threads});
  }
  return hosts;
}

std::set<NodeId> Coordinator::nodes() const {
  std::set<NodeId> nodes;
  for (const Host& host : hosts()) nodes.insert(host.node);
  return nodes;
}

// A new epoch. Each part counts as busy until all its tiles go by the table, and then until what they tell again has
// been heard.
void Coordinator::change_table(const std::vector<Placement>& changes) {
  table_ = next_table(table_, table_.epoch + 1, changes);
  ChangeTable message{table_, part_handles()};
  for (PartOf& p : parts_) p.settled = p.collected = false;
  detector_.restart(nodes());
  if (state_ == State::settling) {
    state_ = State::exchanging;
    quiet_.reset();
  }
  tell_parts(message);
}

void Coordinator::join(const NodeHandle& node) {
  if (state_ == State::finishing || state_ == State::ending) return;
  if (state_ == State::finding) {
    asked_.push_back(node);
    return find(node);
  }
  parts_.emplace_back().node = node;
  prepare(NodeId{static_cast<std::uint32_t>(parts_.size() - 1)});
  parts_.back().open.say(node);
}

// A part that has come later. It has no tiles yet, and so nothing to settle.
void Coordinator::welcome(NodeId node) {
  begin(node);
  detector_.restart(nodes());
  parts_.at(node.value).settled = state_ == State::settling;
  waiting_.push_back(node);
  if (state_ == State::settling) return;
  std::vector<std::uint64_t> held(parts_.size());
  for (const TileId t : options_.order) held[table_.node_of(t).value] += options_.points[t.value];
  const std::vector<Host> there = hosts();
  for (const Host& host : there) {
    if (host.node == node) continue;
    releasing_.insert(host.node);
    send(parts_[host.node.value].part, Release{held[host.node.value] / there.size()});
  }
  place_orphans();
}

void Coordinator::take(PartReleased& released) {
  if (releasing_.erase(released.node) == 0) return;  // lost meanwhile, and its tiles with it
  released_.insert(released_.end(), released.tiles.begin(), released.tiles.end());
  place_orphans();
}

void Coordinator::lose(const NodeHandle& node, Failure failure) {
  if (std::erase(asked_, node) > 0 && asked_.empty()) return take_over();
  for (std::uint32_t n = 0; n < parts_.size(); ++n) {
    if (parts_[n].node == node) return lose(NodeId{n}, std::move(failure));
  }
}

void Coordinator::lose(NodeId node, Failure failure) {
  PartOf& p = parts_.at(node.value);
  if (p.ended) return;
  p.lost = p.ended = true;
  if (p.part) demonitor(p.part.address());
  p.part = nullptr;
  if (state_ == State::finishing || state_ == State::ending) return finish_if_over();
  if (all([](const PartOf&) { return false; })) return fail(std::move(failure));  // there is no other
  if (state_ == State::opening) return begin_if_opened();
  for (const TileId t : options_.order) {
    if (table_.node_of(t) == node && !stored_[t.value]) lost_.push_back(t);
  }
  releasing_.erase(node);
  place_orphans();
}

// All at once, when it is known which there are. Until then nothing is believed quiet, or finished.
void Coordinator::place_orphans() {
  const std::vector<Host> all = hosts();
  if (!releasing_.empty() || all.empty()) return;  // a part that is being opened will take them
  std::vector<Host> late;
  std::copy_if(all.begin(), all.end(), std::back_inserter(late), [&](const Host& host) {
    return std::find(waiting_.begin(), waiting_.end(), host.node) != waiting_.end();
  });
  waiting_.clear();
  auto changes = place_again(table_, std::exchange(lost_, {}), options_.points, all);
  const auto moved = place_again(table_, std::exchange(released_, {}), options_.points, late.empty() ? all : late);
  changes.insert(changes.end(), moved.begin(), moved.end());
  if (!changes.empty()) return change_table(changes);
  if (state_ == State::exchanging) {
    detector_.restart(nodes());
    act(detector_.notice());
  }
  finish_if_collected();
}

void Coordinator::act(QuiescenceDetector::Verdict verdict) {
  switch (verdict) {
    case QuiescenceDetector::Verdict::wait:
      return;
    case QuiescenceDetector::Verdict::probe:
      return tell_parts(Probe{detector_.wave()});
    case QuiescenceDetector::Verdict::quiet:
      quiet_ = std::chrono::steady_clock::now();
      state_ = State::settling;
      if (options_.on_quiet) options_.on_quiet(table_);
      return tell_parts(Settle{});
  }
}

// From here on no tile needs another one: what they know is on scratch.
void Coordinator::collect() {
  if (Status marked = options_.mark_settled(true); !marked) return fail(failure_of(std::move(marked).error()));
  state_ = State::collecting;
  tell_parts(Collect{});
}

void Coordinator::finish_if_collected() {
  const bool over = all([](const PartOf& p) { return p.collected || !p.opened; });
  if (state_ != State::collecting || !releasing_.empty() || !lost_.empty() || !over) return;
  state_ = State::finishing;
  tell_parts(Finish{});
}

void Coordinator::show_progress(PartProgress& message) {
  if (state_ == State::finding || parts_.at(message.node.value).lost) return;
  RunProgress progress;
  progress.sum.spans = std::move(message.spans);
  parts_.at(message.node.value).progress = std::move(message);
  progress.stage = quiet_ ? RunStage::collecting : begun_ ? RunStage::splaying : RunStage::triangulating;
  for (const PartOf& p : parts_) {
    progress.sum.tiles_begun += p.progress.tiles_begun;
    progress.sum.points_begun += p.progress.points_begun;
    progress.sum.tiles_stored += p.progress.tiles_stored;
    progress.sum.tiles_asleep += p.progress.tiles_asleep;
    progress.sum.updates_sent += p.progress.updates_sent;
    progress.sum.updates_processed += p.progress.updates_processed;
    progress.sum.points_sent += p.progress.points_sent;
    progress.sum.memory_bytes += p.progress.memory_bytes;
  }
  owner_.progressed(progress);
}

void Coordinator::fail(Failure failure) {
  if (state_ == State::collecting && failure.code == static_cast<std::uint8_t>(Errc::corrupt)) {
    again_ = options_.mark_settled(false).has_value();  // if not, this failure is still the one to tell
  }
  const bool interrupted = failure.code == static_cast<std::uint8_t>(Errc::interrupted);
  if (!interrupted || state_ == State::ending) return give_up(std::move(failure));
  failure_ = std::move(failure);
  state_ = State::ending;
  tell_parts(Suspend{});
  finish_if_over();
}

void Coordinator::give_up(Failure failure) noexcept {
  if (!failure_) failure_ = std::move(failure);
  state_ = State::ending;
  abort_parts();
  finish_if_over();
}

void Coordinator::abort_parts() noexcept {
  for (PartOf& p : parts_) p.abort.say(p.part);
}

void Coordinator::ended(PartEnded& message) {
  if (state_ == State::finding) {  // it had answered: its node may open another
    for (PartFound& found : answers_) {
      if (found.part && found.self == message.node) found.part = nullptr;
    }
    return;
  }
  PartOf& p = parts_.at(message.node.value);
  if (std::exchange(p.ended, true)) return;
  p.part = nullptr;
  sum_.points += message.points;
  sum_.updates += message.updates;
  sum_.hops = std::max(sum_.hops, message.hops);
  sum_.most_received = std::max(sum_.most_received, message.most_received);
  sum_.sleeps += message.sleeps;
  sum_.begin_us += message.begin_us;
  sum_.splay_us += message.splay_us;
  sum_.collect_us += message.collect_us;
  if (message.failure) return fail(std::move(message.failure));
  finish_if_over();
}

void Coordinator::lost_actor(const caf::down_msg& down) {
  const auto asked =
      std::find_if(asked_.begin(), asked_.end(), [&](const NodeHandle& node) { return node.address() == down.source; });
  if (asked != asked_.end()) return lose(NodeHandle(*asked), lost("a node", down.reason));
  for (std::uint32_t n = 0; n < parts_.size(); ++n) {
    const PartOf& p = parts_[n];
    const bool node = p.node && down.source == p.node.address();
    const bool part = p.part && down.source == p.part.address();
    if ((!node && !part) || p.ended) continue;
    if (node && p.opened) continue;  // its part lives on, or will be missed by itself
    return lose(NodeId{n}, lost(node ? "a node" : "a node's part of the job", down.reason));
  }
}

void Coordinator::finish_if_over() noexcept {
  // A part that is not opened yet will be, or its node is missed: only then is it known that nothing goes on there.
  if (told_ || !all([](const PartOf& p) { return p.ended; })) return;
  told_ = true;
  const auto now = std::chrono::steady_clock::now();
  RunEnded end;
  if (failure_) end.failure = std::move(*failure_);
  end.again = again_;
  end.waves = detector_.wave();
  end.sum = std::move(sum_);
  end.triangulate_us = microseconds(begun_.value_or(now) - started_);
  end.splay_us = microseconds(quiet_.value_or(now) - begun_.value_or(now));
  end.collect_us = microseconds(now - quiet_.value_or(now));
  owner_.ended(std::move(end));
  quit();
}

}  // namespace tessera
