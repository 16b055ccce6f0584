#include "actors/harness/life.h"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <exception>
#include <utility>

#include "actors/node_actor.h"

namespace tessera {
namespace {

constexpr std::uint64_t steps_max = 20'000'000;
constexpr std::uint32_t grace_s = 1000;  // longer than any run lasts

// Each coordinator is in a process of its own.
NodeId home_of_coordinator(std::size_t number) { return NodeId{1'000'000 + static_cast<std::uint32_t>(number)}; }

}  // namespace

Life::Config::Config() {
  add_message_types<caf::id_block::tessera>();
  module_factories.push_back(
      [](caf::actor_system& system) -> caf::actor_system::module* { return new SeededScheduler(system); });
}

Life::Life(const HarnessOptions& options, const Setting& setting, MemoryStorage& storage, LaterStages* later,
           std::mt19937_64& rng)
    : options_(options),
      setting_(setting),
      storage_(storage),
      later_(later),
      rng_(rng),
      truths_(later ? 1 + later->count() : 1, Truth(options.memory_faults)),
      network_state_{0, options.memory_faults},
      system_(config_),
      scheduler_(dynamic_cast<SeededScheduler&>(system_.scheduler())),
      network_(system_.spawn<Network>(network_state_, options_.trace, rng_(), setting_.patience)),
      usher_(system_.spawn<Usher>(*this)) {}

Outcome Life::live(End end, std::uint64_t end_at) {
  for (std::uint32_t n = 0; n < setting_.nodes; ++n) add_node(NodeId{n});
  Losses losses(options_.faults, setting_.nodes, rng_);
  scheduler_.run_all();  // from here on nodes and network wait for messages
  storage_.take_reads();
  add_coordinator();
  while (outcome_.failure.empty() && outcome_.steps < steps_max && !options_.stop.stop_requested()) {
    if (end != End::never && outcome_.steps == end_at) {
      tell(end == End::kill ? "killed" : "cancelled");
      if (end == End::kill) break;
      caf::anon_send(coordinators_.back(), Cancel{});
    }
    if (!ended()) losses.befall(outcome_.steps, *this);
    // A tile may be stored at any moment, and at the latest when nothing else can happen.
    if (rng_() % 16 == 0 && storage_.store_one(rng_)) continue;
    if (!step() && !storage_.store_one(rng_)) {
      const auto next = losses.next_step();
      // The drawn losses do not include nodes whose scratch has failed, so another node may be needed.
      if (!ended() && !next && nobody_is_left()) {
        join(NodeId{nodes_.rbegin()->first.value + 1});
        continue;
      }
      if (ended() || !next) break;
      outcome_.steps = std::max(outcome_.steps, *next);
      continue;
    }
    ++outcome_.steps;
    if (!losses.any() && storage_.failed().empty() &&
        !std::all_of(truths_.begin(), truths_.end(), [](const Truth& truth) { return truth.agrees(); }))
      outcome_.failure = "the counters of the tiles do not tell what is under way";
  }
  outcome_.ended = ended();
  end_all();
  for (const Truth& truth : truths_) outcome_.updates += truth.sent();
  if (outcome_.failure.empty() && end != End::kill && !outcome_.ended) {
    outcome_.failure = "no end after " + std::to_string(outcome_.steps) + " steps";
  }
  // When there is no memory for a tile's image, the tile begins again.
  const bool begun = storage_.take_begun() > 1 && !options_.memory_faults;
  const bool again = begun || (outcome_.ended && outcome_.ended->tiles_again > 0);
  if (options_.faults.orderly() && outcome_.failure.empty() && again)
    outcome_.failure = "a tile began again where nodes left in order";
  // It was settled from the start.
  const bool settled = outcome_.ended && !outcome_.ended->failure && outcome_.ended->waves == 0;
  if (settled && !losses.any() && storage_.failed().empty() && storage_.take_reads() > 1) {
    outcome_.failure = "a run that was settled reads what it is built from more than once";
  }
  return std::move(outcome_);
}

bool Life::nobody_is_left() const {
  return std::all_of(nodes_.begin(), nodes_.end(), [&](const auto& node) {
    return given_up_.contains(node.first) || storage_.failed().contains(node.first);
  });
}

std::vector<ExchangeWatch*> Life::watches() {
  std::vector<ExchangeWatch*> watches;
  for (Truth& truth : truths_) watches.push_back(&truth);
  return watches;
}

void Life::add_node(NodeId home, std::uint64_t memory_bytes) {
  const Turn ours(options_.memory_faults, false);
  NodeOptions node;
  node.memory_bytes = memory_bytes;
  node.progress_interval = std::chrono::hours(24);
  node.hooks = {options_.trace, network_, home};
  nodes_[home] = system_.spawn<NodeActor>(std::move(node),
                                          std::make_shared<MemoryShares>(setting_, storage_, watches(), home, later_));
}

CoordinatorOptions Life::coordinator_options() {
  CoordinatorOptions job;
  const std::size_t number = coordinators_.size();
  job.spec = setting_.spec;
  job.stages = later_ ? 1 + later_->count() : 1;
  job.spec.table.stage = first_stage();
  job.spec.grace_s = options_.faults.waits() ? grace_s : 0;
  job.term = Term{static_cast<std::uint32_t>(number)};
  job.take_over = number > 0;
  job.home = home_of_coordinator(number);
  for (std::uint32_t t = 0; t < setting_.tiles.size(); ++t) {
    job.weights.push_back(setting_.tiles[t].size());
    if (!setting_.tiles[t].empty()) job.order.push_back(TileId{t});
  }
  job.first_stage = [this]() -> Result<std::uint32_t> { return first_stage(); };
  job.mark_settled = [this, number](std::uint32_t stage, bool settled) -> Status {
    if (number + 1 < owners_.size()) return error(Errc::io, "another coordinator has taken over");
    storage_.settled = stage + (settled ? 1 : 0);
    if (!settled) storage_.forget_settled(stage);
    return success();
  };
  job.replaced = [this, number] { return number + 1 < owners_.size(); };
  job.is_settled = [this](std::uint32_t stage) -> Result<bool> { return storage_.settled > stage; };
  job.stored = [this](std::uint32_t stage) -> Result<std::vector<TileReceipt>> {
    return stage == 0 ? storage_.stored() : later_->stored(stage - 1);
  };
  job.on_quiet = [this, number](const RoutingTable& table) {
    if (number + 1 == owners_.size()) believed_quiet(table);
  };
  return job;
}

// The stage with which a job begins when no node has a share of it.
std::uint32_t Life::first_stage() const { return std::max(storage_.settled, 1U) - 1; }

void Life::add_coordinator() {
  const Turn ours(options_.memory_faults, false);
  std::vector<NodeHandle> nodes;
  for (const auto& [home, node] : nodes_) {
    if (!given_up_.contains(home)) nodes.push_back(node);
  }
  began_alone_ = nodes.empty();
  owners_.push_back(std::make_unique<Owner>());
  auto job = coordinator_options();
  coordinators_.push_back(system_.spawn<Coordinator>(std::move(job), *owners_.back(), std::move(nodes)));
  for (const NodeId home : leaving_) tell_that_leaves(home);
}

void Life::believed_quiet(const RoutingTable& table) {
  const Turn ours(options_.memory_faults, false);
  tell("coordinator: quiet");
  // Number of terms, and of tables in the last one.
  outcome_.epochs = std::uint64_t{table.epoch.term.value} + table.epoch.number;
  const auto under_way = truths_.at(table.stage).under_way(table);
  // Updates to or from dead incarnations may still be under way.
  if (under_way != 0 || (table.epoch == setting_.spec.table.epoch && network_state_.held > 0)) {
    outcome_.failure = "quiescence believed with " + std::to_string(under_way) + " updates not processed";
  }
}

bool Life::step() {
  const Turn theirs(options_.memory_faults, true);
  try {
    return scheduler_.step(rng_);
  } catch (const std::exception& e) {
    const Turn ours(options_.memory_faults, false);
    outcome_.failure = std::string("an exception would have ended the process: ") + e.what();
    // The actor that has thrown counts as neither dead nor alive.
    system_.await_actors_before_shutdown(false);
    return true;
  }
}

void Life::end_all() {
  scheduler_.thaw();
  for (const auto& [home, node] : nodes_) caf::anon_send_exit(node, caf::exit_reason::kill);
  caf::anon_send_exit(network_, caf::exit_reason::kill);
  caf::anon_send_exit(usher_, caf::exit_reason::kill);
  for (const CoordinatorHandle& coordinator : coordinators_) {
    caf::anon_send_exit(coordinator, caf::exit_reason::kill);
  }
  std::set<NodeId> homes;
  for (const auto& [home, node] : std::exchange(nodes_, {})) homes.insert(home);
  coordinators_.clear();
  do {
    scheduler_.run_all();
  } while (storage_.lose_pending());
  // Ends shares that wait for another coordinator.
  scheduler_.advance_time(std::chrono::seconds(grace_s));
  scheduler_.run_all();
  // Mail on the scratch of lost nodes is removed, because no process reads it. The same holds for nodes that have come,
  // when the run is resumed without them.
  const bool resumed = !outcome_.ended || outcome_.ended->failure;
  for (const NodeId home : homes) {
    const bool gone = given_up_.contains(home) || storage_.failed().contains(home);
    if (!gone && (home.value < setting_.nodes || !resumed)) continue;
    for (std::uint32_t stage = 0; stage < truths_.size(); ++stage) {
      if (!storage_.at(home, stage).clear(ScratchKind::mail)) std::abort();
    }
  }
}

const std::optional<RunEnded>& Life::ended() const { return owners_.back()->end(); }

void Life::tell(const std::string& what) const {
  if (options_.trace) options_.trace(what);
}

void Life::stop(NodeId node) {
  tell("node " + to_string(node) + " stops");
  scheduler_.freeze(node);
}

void Life::go_on(NodeId node) {
  tell("node " + to_string(node) + " goes on");
  scheduler_.thaw(node);
}

void Life::give_up(NodeId node) {
  tell("node " + to_string(node) + " is given up");
  given_up_.insert(node);
  leaving_.erase(node);
  caf::anon_send(coordinators_.back(), NodeLost{caf::actor_cast<caf::actor>(nodes_.at(node))});
}

void Life::join(NodeId node) {
  tell("node " + to_string(node) + " joins");
  add_node(node);
  tell_of(node);
}

void Life::leave(NodeId node) {
  tell("node " + to_string(node) + " is to leave");
  leaving_.insert(node);
  tell_that_leaves(node);
}

void Life::tell_that_leaves(NodeId node) {
  caf::anon_send(coordinators_.back(),
                 NodeLeaves{caf::actor_cast<caf::actor>(nodes_.at(node)), caf::actor_cast<caf::actor>(usher_)});
}

void Life::let(const NodeLet& let) {
  const Turn ours(options_.memory_faults, false);
  // From a coordinator that was replaced.
  if (let.follower != caf::actor_cast<caf::actor>(coordinators_.back())) return;
  for (const auto& [home, node] : nodes_) {
    if (caf::actor_cast<caf::actor>(node) != let.node || given_up_.contains(home)) continue;
    tell("node " + to_string(home) + " leaves");
    give_up(home);
    caf::anon_send(node, Leave{});
  }
}

void Life::join_in_vain(NodeId node) {
  tell("node " + to_string(node) + " joins, without memory");
  add_node(node, 0);
  given_up_.insert(node);
  if (!began_alone_) tell_of(node);
}

void Life::lose(NodeId node) {
  tell("node " + to_string(node) + " is lost");
  given_up_.insert(node);
  leaving_.erase(node);
}

void Life::tell_of(NodeId node) {
  caf::anon_send(coordinators_.back(), NodeJoined{caf::actor_cast<caf::actor>(nodes_.at(node))});
}

void Life::stop_coordinator() {
  tell("the coordinator stops");
  scheduler_.freeze(home_of_coordinator(coordinators_.size() - 1));
}

void Life::take_over() {
  tell("another coordinator takes over");
  add_coordinator();
}

void Life::coordinators_go_on() {
  tell("the coordinators that had stopped go on");
  for (std::size_t n = 0; n < coordinators_.size(); ++n) scheduler_.thaw(home_of_coordinator(n));
}

}  // namespace tessera
