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

Coordinator::Coordinator(caf::actor_config& config, CoordinatorOptions options, caf::actor owner,
                         std::vector<NodeHandle> nodes)
    : CoordinatorHandle::base(config),
      options_(std::move(options)),
      owner_(std::move(owner)),
      detector_(static_cast<std::uint32_t>(nodes.size())) {
  for (NodeHandle& node : nodes) parts_.push_back({std::move(node), {}, false, false, false, false, {}});
}

// Coordinator and parts know each other: one that has ended must not keep the others alive.
void Coordinator::on_exit() {
  parts_.clear();
  owner_ = nullptr;
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
  set_down_handler([this](caf::scheduled_actor*, caf::down_msg& down) { lost_actor(down); });
  set_error_handler(
      [this](caf::scheduled_actor*, caf::error& reason) { fail(lost("a message of the coordinator", reason)); });
  set_exception_handler([this](std::exception_ptr& exception) -> caf::error {
    tell_parts(Abort{});
    RunEnded ended;
    ended.failure = failure_of(exception, "the coordinator");
    if (owner_) caf::anon_send(owner_, std::move(ended));
    return caf::sec::runtime_error;
  });
  monitor(owner_);
  for (std::size_t n = 0; n < parts_.size(); ++n) {
    monitor(parts_[n].node);
    send(parts_[n].node, OpenPart{options_.job, NodeId{static_cast<std::uint32_t>(n)}, to_bytes(options_.spec),
                                  caf::actor_cast<caf::actor>(this)});
  }
  return {
      [this](const PartOpened& message) { opened(message); },
      [this](const PartBegun& message) {
        parts_.at(message.node.value).begun = true;
        if (!begun_ && all([](const PartOf& p) { return p.begun; })) begun_ = std::chrono::steady_clock::now();
      },
      [this](const PartIdle&) {
        if (state_ == State::exchanging) act(detector_.notice());
      },
      [this](const PartTally& tally) {
        if (state_ != State::exchanging) return;
        act(detector_.answer(tally.wave, tally.node, tally.idle, {tally.sent, tally.processed}));
      },
      [this](const PartSettled& message) {
        settled_.insert(message.node);
        if (state_ == State::settling && settled_.size() == parts_.size()) collect();
      },
      [this](const PartProgress& message) {
        parts_.at(message.node.value).progress = message;
        RunProgress progress;
        progress.stage = quiet_ ? RunStage::collecting : begun_ ? RunStage::splaying : RunStage::triangulating;
        for (const PartOf& p : parts_) {
          progress.sum.tiles_begun += p.progress.tiles_begun;
          progress.sum.points_begun += p.progress.points_begun;
          progress.sum.tiles_stored += p.progress.tiles_stored;
          progress.sum.tiles_asleep += p.progress.tiles_asleep;
          progress.sum.batches_sent += p.progress.batches_sent;
          progress.sum.batches_processed += p.progress.batches_processed;
          progress.sum.points_sent += p.progress.points_sent;
          progress.sum.memory_bytes += p.progress.memory_bytes;
        }
        progress.sum.spans = message.spans;
        if (owner_) caf::anon_send(owner_, std::move(progress));
      },
      [this](const TileDone& done) {
        if (owner_) caf::anon_send(owner_, done);
      },
      [this](const PartEnded& message) { ended(message.node, message); },
      [this](const Cancel&) {
        if (state_ == State::ending) return;
        fail(failure_of(error(Errc::interrupted, "interrupted")));
      },
  };
}

void Coordinator::opened(const PartOpened& message) {
  PartOf& p = parts_.at(message.node.value);
  if (message.failure) {
    p.opened = p.ended = true;
    return fail(message.failure);
  }
  p.opened = true;
  p.settled = message.settled;
  p.part = caf::actor_cast<PartHandle>(message.part);
  monitor(p.part);
  if (state_ == State::ending) {  // the job was given up meanwhile
    send(p.part, Abort{});
    return;
  }
  if (all([](const PartOf& q) { return q.opened; })) begin();
}

void Coordinator::begin() {
  const bool settled = all([](const PartOf& p) { return p.settled; });
  if (!settled) {
    if (const Status marked = options_.mark_settled(false); !marked) return fail(failure_of(marked.error()));
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
  if (const Status marked = options_.mark_settled(true); !marked) return fail(failure_of(marked.error()));
  state_ = State::collecting;
  tell_parts(Collect{});
}

void Coordinator::fail(const Failure& failure) {
  if (!failure_) failure_ = failure;
  if (state_ == State::collecting && failure.code == static_cast<std::uint8_t>(Errc::corrupt)) {
    again_ = options_.mark_settled(false).has_value();  // if not, this failure is still the one to tell
  }
  if (state_ != State::ending) {
    state_ = State::ending;
    if (failure.code == static_cast<std::uint8_t>(Errc::interrupted)) {
      tell_parts(Suspend{});
    } else {
      tell_parts(Abort{});
    }
  }
  finish_if_over();
}

void Coordinator::ended(NodeId node, const PartEnded& message) {
  PartOf& p = parts_.at(node.value);
  if (std::exchange(p.ended, true)) return;
  p.part = nullptr;
  sum_.points += message.points;
  sum_.batches += message.batches;
  sum_.rounds = std::max(sum_.rounds, message.rounds);
  sum_.sleeps += message.sleeps;
  sum_.begin_us += message.begin_us;
  sum_.splay_us += message.splay_us;
  sum_.collect_us += message.collect_us;
  if (message.failure) return fail(message.failure);
  finish_if_over();
}

void Coordinator::lost_actor(const caf::down_msg& down) {
  if (owner_ && down.source == owner_.address()) {
    owner_ = nullptr;
    return fail(lost("whoever runs the job", down.reason));
  }
  for (PartOf& p : parts_) {
    const bool node = p.node && down.source == p.node.address();
    const bool part = p.part && down.source == p.part.address();
    if (!node && !part) continue;
    if (p.ended) continue;
    if (node && p.opened) continue;  // its part lives on, or will be missed by itself
    p.ended = true;
    p.part = nullptr;
    fail(lost(node ? "a node" : "a node's part of the job", down.reason));
  }
}

void Coordinator::finish_if_over() {
  // A part that is not opened yet will be, or its node is missed: only then is it known that nothing goes on there.
  if (told_ || !all([](const PartOf& p) { return p.ended; })) return;
  told_ = true;
  if (owner_) {
    const auto now = std::chrono::steady_clock::now();
    RunEnded message;
    if (failure_) message.failure = *failure_;
    message.again = again_;
    message.waves = detector_.wave();
    message.sum = sum_;
    message.triangulate_us = microseconds(begun_.value_or(now) - started_);
    message.splay_us = microseconds(quiet_.value_or(now) - begun_.value_or(now));
    message.collect_us = microseconds(now - quiet_.value_or(now));
    caf::anon_send(owner_, std::move(message));
  }
  quit();
}

}  // namespace tessera
