#include "actors/coordinator.h"

#include <algorithm>
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
      detector_(static_cast<std::uint32_t>(nodes.size())) {
  for (NodeHandle& node : nodes) parts_.emplace_back().node = std::move(node);
}

// All nodes are asked or none: what is opened must be told how it ends.
void Coordinator::initialize() {
  SteadyActor::initialize();
  for (PartOf& p : parts_) p.open.say(p.node);
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
  return std::all_of(parts_.begin(), parts_.end(), done);
}

Coordinator::behavior_type Coordinator::make_behavior() {
  set_down_handler([this](caf::scheduled_actor*, caf::down_msg& down) { attempt([&] { lost_actor(down); }); });
  set_error_handler([this](caf::scheduled_actor*, caf::error& reason) {
    attempt([&] { fail(lost("a message of the coordinator", reason)); });
  });
  for (std::size_t n = 0; n < parts_.size(); ++n) {
    monitor(parts_[n].node);
    parts_[n].open.message() = {options_.job, NodeId{static_cast<std::uint32_t>(n)}, to_bytes(options_.spec),
                                caf::actor_cast<caf::actor>(this)};
  }
  return {
      [this](const PartOpened& message) { attempt([&] { opened(message); }); },
      [this](const PartBegun& message) {
        parts_.at(message.node.value).begun = true;
        if (!begun_ && all([](const PartOf& p) { return p.begun; })) begun_ = std::chrono::steady_clock::now();
      },
      [this](const PartIdle&) {
        attempt([&] {
          if (state_ == State::exchanging) act(detector_.notice());
        });
      },
      [this](const PartTally& tally) {
        attempt([&] {
          if (state_ != State::exchanging) return;
          act(detector_.answer(tally.wave, tally.node, tally.idle, {tally.sent, tally.processed}));
        });
      },
      [this](const PartSettled& message) {
        attempt([&] {
          settled_.insert(message.node);
          if (state_ == State::settling && settled_.size() == parts_.size()) collect();
        });
      },
      [this](PartProgress& message) { attempt([&] { show_progress(message); }); },
      [this](const TileDone& done) { attempt([&] { owner_.stored(done); }); },
      [this](PartEnded& message) { attempt([&] { ended(message); }); },
      [this](const Cancel&) {
        if (state_ != State::ending) attempt([&] { fail(failure_of(error(Errc::interrupted, "interrupted"))); });
      },
  };
}

void Coordinator::opened(const PartOpened& message) {
  PartOf& p = parts_.at(message.node.value);
  p.opened = true;
  if (message.failure) {
    p.ended = true;
    return fail(message.failure);
  }
  p.settled = message.settled;
  p.part = caf::actor_cast<PartHandle>(message.part);
  if (state_ == State::ending) return abort_parts();  // the job was given up meanwhile
  monitor(p.part);
  if (all([](const PartOf& q) { return q.opened; })) begin();
}

void Coordinator::begin() {
  const bool settled = all([](const PartOf& p) { return p.settled; });
  if (!settled) {
    if (Status marked = options_.mark_settled(false); !marked) return fail(failure_of(std::move(marked).error()));
  }
  started_ = std::chrono::steady_clock::now();
  state_ = settled ? State::collecting : State::exchanging;
  if (settled) begun_ = quiet_ = started_;
  BeginPart message;
  message.settled = settled;
  for (const PartOf& p : parts_) message.parts.push_back(caf::actor_cast<caf::actor>(p.part));
  tell_parts(message);
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
      if (options_.on_quiet) options_.on_quiet();
      return tell_parts(Settle{});
  }
}

// From here on no tile needs another one: what they know is on scratch.
void Coordinator::collect() {
  if (Status marked = options_.mark_settled(true); !marked) return fail(failure_of(std::move(marked).error()));
  state_ = State::collecting;
  tell_parts(Collect{});
}

void Coordinator::show_progress(PartProgress& message) {
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
  for (PartOf& p : parts_) {
    const bool node = p.node && down.source == p.node.address();
    const bool part = p.part && down.source == p.part.address();
    if ((!node && !part) || p.ended) continue;
    if (node && p.opened) continue;  // its part lives on, or will be missed by itself
    p.ended = true;
    p.part = nullptr;
    fail(lost(node ? "a node" : "a node's part of the job", down.reason));
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
