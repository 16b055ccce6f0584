#include "actors/coordinator.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "actors/failing.h"

namespace tessera {

Coordinator::Coordinator(caf::actor_config& config, CoordinatorOptions options, RunOwner& owner,
                         std::vector<NodeHandle> nodes)
    : SteadyActor(config),
      options_(std::move(options)),
      owner_(owner),
      detector_({}),
      table_(options_.spec.table),
      stored_(options_.weights.size()) {
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
    if (!leaving_.empty()) let_go();
  } catch (...) {
    give_up(failure_of(std::current_exception(), [] { return std::string("the coordinator"); }));
  }
}

Coordinator::behavior_type Coordinator::make_behavior() {
  set_down_handler([this](caf::scheduled_actor*, caf::down_msg& down) { attempt([&] { lost_actor(down); }); });
  set_error_handler([this](caf::scheduled_actor*, caf::error& reason) {
    attempt([&] { fail(lost("a message of the coordinator", reason)); });
  });
  const SharedBytes spec = spec_bytes();
  for (std::size_t n = 0; n < parts_.size(); ++n) prepare(NodeId{static_cast<std::uint32_t>(n)}, spec);
  return {
      [this](const PartOpened& message) { attempt([&] { opened(message); }); },
      [this](PartFound& message) { attempt([&] { found(message); }); },
      [this](const PartBegun& message) {
        if (!has(message.node)) return;
        parts_[message.node.value].begun = true;
        if (all([](const PartOf& p) { return p.begun || !p.opened; }))
          account_.all_have_begun(std::chrono::steady_clock::now());
      },
      [this](const PartIdle& idle) {
        attempt([&] {
          if (state_ == State::exchanging) act(detector_.notice(idle.node));
        });
      },
      [this](const PartTally& tally) {
        attempt([&] {
          if (state_ != State::exchanging || tally.epoch != table_.epoch) return;
          if (!releasing_.empty() || !handing_.empty() || !lost_.empty() || !released_.empty()) return;
          act(detector_.answer(tally.wave, tally.node, tally.idle, {tally.sent, tally.processed}));
        });
      },
      [this](const PartSettled& message) {
        attempt([&] {
          if (message.epoch != table_.epoch || state_ != State::settling || !has(message.node)) return;
          parts_.at(message.node.value).settled = true;
          collect_if_settled();
        });
      },
      [this](const PartCollected& message) {
        attempt([&] {
          if (message.epoch != table_.epoch || state_ != State::collecting || !has(message.node)) return;
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
          lose(caf::actor_cast<NodeHandle>(lost.node), failure_of(error(Errc::internal, "the last node is lost")),
               lost.why);
        });
      },
      [this](const NodeLeaves& leaves) { attempt([&] { leave(leaves); }); },
      [this](const NodeBack& back) { attempt([&] { note(back); }); },
      [this](const NobodyCame& over) { attempt([&] { give_up_waiting(over); }); },
      [this](const NodeJoined& joined) { attempt([&] { join(caf::actor_cast<NodeHandle>(joined.node)); }); },
      [this](PartProgress& message) { attempt([&] { show_progress(message); }); },
      [this](const TileDone& done) { attempt([&] { take(done); }); },
      [this](PartEnded& message) { attempt([&] { ended(message); }); },
      [this](const Cancel&) {
        if (state_ != State::ending) attempt([&] { fail(failure_of(error(Errc::interrupted, "interrupted"))); });
      },
  };
}

SharedBytes Coordinator::spec_bytes() const {
  PartSpec spec = options_.spec;
  spec.table = table_;
  return to_bytes(spec);
}

void Coordinator::prepare(NodeId node, const SharedBytes& spec) {
  PartOf& p = parts_[node.value];
  monitor(p.node);
  p.open.message() = {options_.job, node, spec, caf::actor_cast<caf::actor>(this), options_.term};
  p.abort.message().term = options_.term;
}

void Coordinator::opened(const PartOpened& message) {
  PartOf& p = parts_.at(message.node.value);
  p.opened = true;
  if (message.failure) return not_opened(message);
  account_.node_came();
  p.settled = message.settled;
  p.threads = message.threads;
  p.memory_bytes = message.memory_bytes;
  p.name = message.name;
  p.part = caf::actor_cast<PartHandle>(message.part);
  if (state_ == State::finishing) p.lost = p.ended = true;  // it is not needed any more
  if (p.lost || state_ == State::ending) {
    p.abort.say(p.part);
    return finish_if_over();
  }
  monitor(p.part);
  if (state_ == State::opening) return begin_if_opened();
  if (!p.name.empty()) owner_.said("node " + p.name + " has come, and takes part");
  welcome(message.node);
}

BeginPart Coordinator::beginning() const { return {part_handles(), table_, state_ == State::collecting}; }

void Coordinator::take(const TileDone& done) {
  if (done.stage != table_.stage) return;  // by one that was lost in the stage before
  const TileId tile = done.tile.tile;
  if (stored_.at(tile.value)) return;  // by a node that was lost, too
  stored_[tile.value] = true;
  owner_.stored(done);
}

void Coordinator::begin_if_opened() {
  if (all([](const PartOf& p) { return p.opened; })) begin();
}

void Coordinator::begin() {
  const bool settled = all([](const PartOf& p) { return p.settled; });
  if (!settled) {
    if (Status marked = options_.mark_settled(table_.stage, false); !marked)
      return fail(failure_of(std::move(marked).error()));
  }
  account_.start(std::chrono::steady_clock::now(), settled);
  state_ = settled ? State::collecting : State::exchanging;
  const caf::message message = for_parts(beginning());
  for (const Host& host : hosts()) tell(parts_[host.node.value], message);
  detector_.restart_busy(nodes());
  for (const TileId t : options_.order) {  // of nodes that were lost before anything began
    if (parts_.at(table_.node_of(t).value).lost) released_.push_back(t);
  }
  if (!released_.empty()) place_orphans();
}

void Coordinator::act(QuiescenceDetector::Verdict verdict) {
  switch (verdict) {
    case QuiescenceDetector::Verdict::wait:
      return;
    case QuiescenceDetector::Verdict::probe:
      return tell_parts(Probe{detector_.wave()});
    case QuiescenceDetector::Verdict::quiet:
      account_.is_quiet(std::chrono::steady_clock::now());
      state_ = State::settling;
      if (options_.on_quiet) options_.on_quiet(table_);
      return tell_parts(Settle{});
  }
}

// From here on no tile needs another one: what they know is on scratch.
void Coordinator::collect_if_settled() {
  if (state_ != State::settling || !all([](const PartOf& p) { return p.settled || !p.opened; })) return;
  if (Status marked = options_.mark_settled(table_.stage, true); !marked)
    return fail(failure_of(std::move(marked).error()));
  state_ = State::collecting;
  tell_parts(Collect{});
}

void Coordinator::finish_if_collected() {
  const bool over = all([](const PartOf& p) { return p.collected || !p.opened; });
  if (state_ != State::collecting || !releasing_.empty() || !lost_.empty() || !released_.empty() || !over) return;
  if (table_.stage + 1 < options_.stages) return begin_next_stage();
  state_ = State::finishing;
  if (account_.has_untold()) tell_progress();
  tell_parts(Finish{});
}

void Coordinator::step_down() noexcept {
  told_ = true;
  RunEnded end;
  end.failure = failure_of(error(Errc::interrupted, "another coordinator has taken over"));
  owner_.ended(std::move(end));
  quit();
}

void Coordinator::fail(Failure failure) {
  if (options_.replaced && options_.replaced()) return step_down();
  if (state_ == State::collecting && failure.code == static_cast<std::uint8_t>(Errc::corrupt)) {
    again_ = options_.mark_settled(table_.stage, false).has_value();  // if not, this failure is still the one to tell
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
  if (!has(message.node)) return;
  PartOf& p = parts_[message.node.value];
  if (std::exchange(p.ended, true)) return;
  p.part = nullptr;
  account_.ended(message);
  if (message.failure) {
    if (!p.name.empty() && message.failure.code != static_cast<std::uint8_t>(Errc::interrupted))
      message.failure.text = "node " + p.name + ": " + message.failure.text;
    const bool can = state_ == State::exchanging || state_ == State::settling || state_ == State::collecting;
    if (!message.of_node || !can || hosts().empty()) return fail(std::move(message.failure));
    p.lost = true;
    account_.node_lost();
    return missing(message.node, message.failure,
                   "cannot go on with its scratch folder (" + message.failure.text + ")");
  }
  const bool handed = handing_.contains(message.node) && state_ == State::exchanging;
  if (handed || (p.finished && state_ == State::collecting)) return left(message);
  finish_if_over();
}

void Coordinator::finish_if_over() noexcept {
  // A part that is not opened yet will be, or its node is missed: only then is it known that nothing goes on there.
  const bool ends = state_ == State::finishing || state_ == State::ending;
  if (told_ || !ends || !all([](const PartOf& p) { return p.ended; })) return;
  told_ = true;
  RunEnded end = account_.end(std::chrono::steady_clock::now(), detector_.wave());
  if (failure_) end.failure = std::move(*failure_);
  end.again = again_;
  for (const PartOf& p : parts_) end.memory_bytes += p.memory_bytes;
  owner_.ended(std::move(end));
  quit();
}

}  // namespace tessera
