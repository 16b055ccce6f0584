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
      placements_({options_.weights, options_.order, options_.term}, options_.spec.table),
      course_(options_.take_over ? At::finding : At::opening),
      detector_({}) {
  live_at(options_.home);
  if (options_.take_over) {
    asked_ = std::move(nodes);
  } else {
    for (const NodeHandle& node : nodes) add(node);
  }
}

// Asks all nodes, or none when an exception comes before: a share that is opened must be told how it ends.
void Coordinator::initialize() {
  SteadyActor::initialize();
  for (Participant& p : parts_) p.open.say(p.node);
  for (const NodeHandle& node : asked_) find(node);
}

// Coordinator and shares refer to each other. An actor that has ended must not keep the others alive.
void Coordinator::on_exit() {
  if (!std::exchange(told_, true)) {
    abort_parts();
    RunEnded end;
    end.failure = failure_ ? std::move(*failure_) : ended_unexpectedly();
    owner_.ended(std::move(end));
  }
  for (const Participant& p : parts_) demonitor(p.node.address());
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
      [this](const ShareOpened& message) { attempt([&] { opened(message); }); },
      [this](ShareFound& message) { attempt([&] { found(message); }); },
      [this](const ShareBegun& message) {
        if (!roster_.has(message.node)) return;
        roster_[message.node].begun = true;
        if (roster_.all_have_begun()) account_.all_have_begun(std::chrono::steady_clock::now());
      },
      [this](const ShareIdle& idle) {
        attempt([&] {
          if (course_.is(At::exchanging)) act(detector_.notice(idle.node));
        });
      },
      [this](const ShareTally& tally) {
        attempt([&] {
          if (!course_.is(At::exchanging) || tally.epoch != table().epoch || !placements_.complete()) return;
          act(detector_.answer(tally.wave, tally.node, tally.idle, {tally.sent, tally.processed}));
        });
      },
      [this](const ShareSettled& message) {
        attempt([&] {
          if (message.epoch != table().epoch || !course_.is(At::settling) || !roster_.has(message.node)) return;
          roster_[message.node].reached = Reached::settled;
          collect_if_settled();
        });
      },
      [this](const ShareCollected& message) {
        attempt([&] {
          if (message.epoch != table().epoch || !course_.is(At::collecting) || !roster_.has(message.node)) return;
          roster_[message.node].reached = Reached::collected;
          finish_if_collected();
        });
      },
      [this](ShareReleased& released) {
        attempt([&] {
          if (!course_.is(At::finding) && placements_.take_answer(released.node, released.tiles)) place_orphans();
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
      [this](ShareProgress& message) { attempt([&] { show_progress(message); }); },
      [this](const TileDone& done) { attempt([&] { take(done); }); },
      [this](ShareEnded& message) { attempt([&] { ended(message); }); },
      [this](const Cancel&) {
        if (!course_.is(At::ending)) attempt([&] { fail(failure_of(error(Errc::interrupted, "interrupted"))); });
      },
  };
}

SharedBytes Coordinator::spec_bytes() const {
  ShareSpec spec = options_.spec;
  spec.table = table();
  return to_bytes(spec);
}

void Coordinator::prepare(NodeId node, const SharedBytes& spec) {
  Participant& p = parts_[node.value];
  monitor(p.node);
  p.open.message() = {options_.job, node, spec, caf::actor_cast<caf::actor>(this), options_.term};
  p.abort.message().term = options_.term;
}

void Coordinator::opened(const ShareOpened& message) {
  Participant& p = parts_.at(message.node.value);
  Roster::Node& node = roster_[message.node];
  if (message.failure) return not_opened(message);
  account_.node_came();
  if (!node.gone()) node.standing = Standing::there;
  if (message.settled) node.reached = Reached::settled;
  node.threads = message.threads;
  node.memory_bytes = message.memory_bytes;
  node.name = message.name;
  p.part = caf::actor_cast<ShareHandle>(message.part);
  if (course_.is(At::finishing)) node.standing = Standing::left;  // the share is not needed any more
  if (node.gone() || course_.is(At::ending)) {
    p.abort.say(p.part);
    return finish_if_over();
  }
  monitor(p.part);
  if (course_.is(At::opening)) return begin_if_opened();
  if (!node.name.empty()) owner_.said("node " + node.name + " has come, and takes part");
  welcome(message.node);
}

BeginShare Coordinator::beginning() const { return {part_handles(), table(), course_.is(At::collecting)}; }

void Coordinator::take(const TileDone& done) {
  if (done.stage != table().stage) return;  // from a node that was lost in the stage before
  if (placements_.store(done.tile.tile)) owner_.stored(done);
}

void Coordinator::begin_if_opened() {
  if (roster_.all([](const Roster::Node& node) { return node.standing != Standing::asked; })) begin();
}

void Coordinator::begin() {
  const bool settled = roster_.all([](const Roster::Node& node) { return node.reached == Reached::settled; });
  if (!settled) {
    if (Status marked = options_.mark_settled(table().stage, false); !marked)
      return fail(failure_of(std::move(marked).error()));
  }
  account_.start(std::chrono::steady_clock::now(), settled);
  course_.begin(settled);
  const caf::message message = for_parts(beginning());
  for (const Host& host : hosts()) tell(parts_[host.node.value], message);
  detector_.restart_busy(nodes());
  std::vector<TileId> homeless;  // those of nodes that were lost before anything began
  for (const TileId t : placements_.order()) {
    if (!roster_.has(table().node_of(t))) homeless.push_back(t);
  }
  placements_.release(homeless);
  if (!homeless.empty()) place_orphans();
}

void Coordinator::act(QuiescenceDetector::Verdict verdict) {
  switch (verdict) {
    case QuiescenceDetector::Verdict::wait:
      return;
    case QuiescenceDetector::Verdict::probe:
      return tell_parts(Probe{detector_.wave()});
    case QuiescenceDetector::Verdict::quiet:
      account_.is_quiet(std::chrono::steady_clock::now());
      course_.settle();
      if (options_.on_quiet) options_.on_quiet(table());
      return tell_parts(Settle{});
  }
}

// From here on no tile needs another tile, because what tiles know of each other is on scratch.
void Coordinator::collect_if_settled() {
  if (!course_.is(At::settling) || !roster_.all_reached(Reached::settled)) return;
  if (Status marked = options_.mark_settled(table().stage, true); !marked)
    return fail(failure_of(std::move(marked).error()));
  course_.collect();
  tell_parts(Collect{});
}

void Coordinator::finish_if_collected() {
  if (!course_.is(At::collecting) || !placements_.complete() || !roster_.all_reached(Reached::collected)) return;
  if (table().stage + 1 < options_.stages) return begin_next_stage();
  course_.finish();
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
  if (course_.is(At::collecting) && failure.code == static_cast<std::uint8_t>(Errc::corrupt)) {
    // If that cannot be written, this failure is still the one to tell.
    again_ = options_.mark_settled(table().stage, false).has_value();
  }
  const bool interrupted = failure.code == static_cast<std::uint8_t>(Errc::interrupted);
  if (!interrupted || course_.is(At::ending)) return give_up(std::move(failure));
  failure_ = std::move(failure);
  course_.end();
  tell_parts(Suspend{});
  finish_if_over();
}

void Coordinator::give_up(Failure failure) noexcept {
  if (!failure_) failure_ = std::move(failure);
  course_.end();
  abort_parts();
  finish_if_over();
}

void Coordinator::abort_parts() noexcept {
  for (Participant& p : parts_) p.abort.say(p.part);
}

void Coordinator::ended(ShareEnded& message) {
  // The share had answered. It has ended, and its node may open another one.
  if (course_.is(At::finding)) {
    for (ShareFound& found : answers_) {
      if (found.part && found.self == message.node) found.part = nullptr;
    }
    return;
  }
  if (!roster_.has(message.node) || roster_[message.node].over()) return;
  Roster::Node& node = roster_[message.node];
  node.standing = Standing::ended;
  parts_[message.node.value].part = nullptr;
  account_.ended(message);
  if (message.failure) {
    if (!node.name.empty() && message.failure.code != static_cast<std::uint8_t>(Errc::interrupted))
      message.failure.text = "node " + node.name + ": " + message.failure.text;
    if (!message.of_node || !course_.works() || hosts().empty()) return fail(std::move(message.failure));
    node.standing = Standing::lost;
    account_.node_lost();
    return missing(message.node, message.failure,
                   "cannot go on with its scratch folder (" + message.failure.text + ")");
  }
  const bool handed = placements_.hands_over(message.node) && course_.is(At::exchanging);
  if (handed || (node.dismissed && course_.is(At::collecting))) return left(message);
  finish_if_over();
}

void Coordinator::finish_if_over() noexcept {
  // A share that is not open yet will be, or its node will be missed. Only then is it known that no work goes on there.
  if (told_ || !course_.ends() || !roster_.all([](const Roster::Node& node) { return node.over(); })) return;
  told_ = true;
  RunEnded end = account_.end(std::chrono::steady_clock::now(), detector_.wave().value);
  if (failure_) end.failure = std::move(*failure_);
  end.again = again_;
  for (const Roster::Node& node : roster_.nodes()) end.memory_bytes += node.memory_bytes;
  owner_.ended(std::move(end));
  quit();
}

}  // namespace tessera
