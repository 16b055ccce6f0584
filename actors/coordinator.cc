#include "actors/coordinator.h"

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
      detector_({}),
      room_(options_.weight_max, options_.tile_in_words) {
  live_at(options_.home);
  for (const NodeHandle& node : nodes) {
    if (options_.take_over) {
      ask(node);
    } else {
      add(node);
    }
  }
}

// Asks all nodes, or none when an exception comes before: a share that is opened must be told how it ends.
void Coordinator::initialize() {
  SteadyActor::initialize();
  for (Participant& p : participants_) p.open.say(p.node);
  for (const Asked& asked : asked_) find(asked.node);
}

// Coordinator and shares refer to each other. An actor that has ended must not keep the others alive.
void Coordinator::on_exit() {
  if (!std::exchange(told_, true)) {
    abort_shares();
    RunEnded end;
    end.failure = failure_ ? std::move(*failure_) : ended_unexpectedly();
    owner_.ended(std::move(end));
  }
  for (const Participant& p : participants_) demonitor(p.node.address());
  participants_.clear();
  asked_.clear();
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
  for (std::size_t n = 0; n < participants_.size(); ++n) prepare(NodeId{static_cast<std::uint32_t>(n)}, spec);
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
          if (!course_.is(At::finding) && placements_.take_answer(released.node, released.tiles)) place_homeless();
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

void Coordinator::begin_if_opened() {
  if (roster_.all_have_answered()) begin();
}

void Coordinator::begin() {
  const bool settled = roster_.all([](const Roster::Node& node) { return node.reached == Reached::settled; });
  if (!settled) {
    if (Status marked = options_.mark_settled(table().stage, false); !marked)
      return fail(failure_of(std::move(marked).error()));
  }
  account_.start(std::chrono::steady_clock::now(), settled);
  course_.begin(settled);
  const caf::message message = for_shares(beginning());
  for (const Host& host : hosts()) tell(participants_[host.node.value], message);
  detector_.restart_busy(nodes());
  // Nodes may have been lost before anything began.
  if (placements_.release_homeless(lives()) > 0) place_homeless();
}

BeginShare Coordinator::beginning() const { return {share_handles(), table(), course_.is(At::collecting)}; }

void Coordinator::take(const TileDone& done) {
  if (done.stage != table().stage) return;  // from a node that was lost in the stage before
  if (placements_.store(done.tile.tile)) owner_.stored(done);
}

void Coordinator::act(QuiescenceDetector::Verdict verdict) {
  switch (verdict) {
    case QuiescenceDetector::Verdict::wait:
      return;
    case QuiescenceDetector::Verdict::probe:
      return tell_shares(Probe{detector_.wave()});
    case QuiescenceDetector::Verdict::quiet:
      account_.is_quiet(std::chrono::steady_clock::now());
      course_.settle();
      if (options_.on_quiet) options_.on_quiet(table());
      return tell_shares(Settle{});
  }
}

// Some tiles begin again, or go on elsewhere.
void Coordinator::is_disturbed() {
  if (course_.disturb()) account_.is_not_quiet();
}

// From here on no tile needs another tile, because what tiles know of each other is on scratch.
void Coordinator::collect_if_settled() {
  if (!course_.is(At::settling) || !roster_.all_reached(Reached::settled)) return;
  if (Status marked = options_.mark_settled(table().stage, true); !marked)
    return fail(failure_of(std::move(marked).error()));
  course_.collect();
  tell_shares(Collect{});
}

void Coordinator::finish_if_collected() {
  if (!course_.is(At::collecting) || !placements_.complete() || !roster_.all_reached(Reached::collected)) return;
  if (table().stage + 1 < options_.stages) return begin_next_stage();
  course_.finish();
  if (account_.has_untold()) tell_progress();
  tell_shares(Finish{});
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

// Sends a table of a new epoch. Each share counts as busy until all its tiles go by the table and what they tell again
// has been processed.
void Coordinator::change_table(const std::vector<Placement>& changes) {
  ChangeTable message{placements_.change(changes), share_handles(), course_.is(At::collecting)};
  roster_.forget_reached();
  detector_.restart_busy(nodes());
  is_disturbed();
  tell_shares(std::move(message));
}

void Coordinator::show_progress(ShareProgress& message) {
  const NodeId node = message.node;
  if (roster_.has(node) && account_.heard(node, std::move(message), participants_.size())) tell_progress();
}

void Coordinator::tell_progress() {
  roster_.count_tiles(placements_);
  std::vector<Account::Node> nodes;
  for (const Roster::Node& node : roster_.nodes())
    nodes.push_back({node.name, node.tiles, node.gone(), node.standing == Standing::left});
  owner_.progressed(account_.progress(nodes));
}

void Coordinator::ended(ShareEnded& message) {
  // The share had answered. It has ended, and its node may open another one.
  if (course_.is(At::finding)) {
    inquiry_.end_share(message.node);
    return;
  }
  if (!roster_.has(message.node) || roster_[message.node].over()) return;
  Roster::Node& node = roster_[message.node];
  node.standing = Standing::ended;
  participants_[message.node.value].share = nullptr;
  account_.ended(message);
  if (message.failure) {
    if (!node.name.empty() && message.failure.code != static_cast<std::uint8_t>(Errc::interrupted))
      message.failure.text = "node " + node.name + ": " + message.failure.text;
    if (!message.of_node || !course_.works() || hosts().empty()) return fail(std::move(message.failure));
    node.standing = Standing::lost;
    account_.node_lost();
    return missing(message.node, message.failure, "cannot use its scratch folder (" + message.failure.text + ")");
  }
  const bool handed = placements_.hands_over(message.node) && course_.is(At::exchanging);
  if (handed || (node.dismissed && course_.is(At::collecting))) return left(message);
  finish_if_over();
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
  tell_shares(Suspend{});
  finish_if_over();
}

void Coordinator::give_up(Failure failure) noexcept {
  if (!failure_) failure_ = std::move(failure);
  course_.end();
  abort_shares();
  finish_if_over();
}

void Coordinator::step_down() noexcept {
  told_ = true;
  RunEnded end;
  end.failure = failure_of(error(Errc::interrupted, "another coordinator has taken over"));
  owner_.ended(std::move(end));
  quit();
}

void Coordinator::abort_shares() noexcept {
  for (Participant& p : participants_) p.abort.say(p.share);
}

void Coordinator::finish_if_over() noexcept {
  // A share that is not open yet will be, or its node will be missed. Only then is it known that no work goes on there.
  if (told_ || !course_.ends() || !roster_.all_are_over()) return;
  told_ = true;
  RunEnded end = account_.end(std::chrono::steady_clock::now(), detector_.wave().value);
  if (failure_) end.failure = std::move(*failure_);
  end.again = again_;
  end.memory_bytes = roster_.memory_bytes();
  owner_.ended(std::move(end));
  quit();
}

std::vector<Host> Coordinator::hosts() const {
  std::vector<Host> hosts;
  for (std::uint32_t n = 0; n < participants_.size(); ++n) {
    const Roster::Node& node = roster_[NodeId{n}];
    if (node.there() && !leaves(participants_[n].node))
      hosts.push_back(room_.host(NodeId{n}, node.threads, node.memory_bytes));
  }
  return hosts;
}

std::set<NodeId> Coordinator::nodes() const {
  std::set<NodeId> nodes;
  for (const Host& host : hosts()) nodes.insert(host.node);
  return nodes;
}

std::vector<caf::actor> Coordinator::share_handles() const {
  std::vector<caf::actor> handles;
  for (const Participant& p : participants_) handles.push_back(caf::actor_cast<caf::actor>(p.share));
  return handles;
}

}  // namespace tessera
