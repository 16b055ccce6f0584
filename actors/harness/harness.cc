#include "actors/harness/harness.h"

#include <algorithm>
#include <caf/all.hpp>
#include <cstdlib>
#include <map>
#include <random>
#include <utility>

#include "actors/coordinator.h"
#include "actors/harness/losses.h"
#include "actors/harness/memory_storage.h"
#include "actors/harness/network.h"
#include "actors/harness/seeded_scheduler.h"
#include "actors/harness/setting.h"
#include "actors/node_actor.h"
#include "src/reference/reference.h"

namespace tessera {
namespace {

constexpr std::uint64_t steps_max = 20'000'000;

class DeterministicConfig : public caf::actor_system_config {
 public:
  DeterministicConfig() {
    add_message_types<caf::id_block::tessera>();
    module_factories.push_back(
        [](caf::actor_system& system) -> caf::actor_system::module* { return new SeededScheduler(system); });
  }
};

// The truth about updates, beside what the tiles count.
class Truth final : public ExchangeWatch {
 public:
  explicit Truth(MemoryFaults* memory_faults) : memory_faults_(memory_faults) {}
  void sent(Peer from, Peer to, Totals now) override {
    const Turn ours(memory_faults_, false);
    ++sent_;
    ++under_way_;
    ++by_pair_[{from, to}];
    note(from, now);
  }
  void processed(Peer from, Peer to, Totals now) override {
    const Turn ours(memory_faults_, false);
    --under_way_;
    --by_pair_[{from, to}];
    note(to, now);
  }
  void rejoined(Peer self, Totals now) override { note(self, now); }
  // Updates that have been sent and not processed, between tiles that live.
  std::int64_t under_way(const Table& table) const {
    std::int64_t sum = 0;
    for (const auto& [pair, updates] : by_pair_) {
      if (table.alive(pair.first) && table.alive(pair.second)) sum += std::abs(updates);
    }
    return sum;
  }
  std::uint64_t sent() const { return sent_; }
  // Whether the counters of all tiles differ by what is under way. As long as no tile has begun again.
  bool agrees() const { return counted_ == under_way_; }

 private:
  void note(Peer self, Totals now) {
    Totals& before = totals_[self];
    counted_ +=
        static_cast<std::int64_t>(now.sent - before.sent) - static_cast<std::int64_t>(now.processed - before.processed);
    before = now;
  }
  MemoryFaults* memory_faults_;
  std::map<Peer, Totals> totals_;
  std::map<std::pair<Peer, Peer>, std::int64_t> by_pair_;
  std::int64_t under_way_ = 0, counted_ = 0;
  std::uint64_t sent_ = 0;
};

struct Outcome {
  std::string failure;  // of the harness: what must not be
  std::optional<RunEnded> ended;
  std::uint64_t steps = 0, updates = 0, epochs = 0;
};

class Owner final : public RunOwner {
 public:
  void progressed(const RunProgress&) override {}
  void stored(const TileDone&) override {}
  void ended(RunEnded end) noexcept override { end_ = std::move(end); }
  const std::optional<RunEnded>& end() const { return end_; }

 private:
  std::optional<RunEnded> end_;
};

// What ends a life early.
enum class End : std::uint8_t { never, cancel, kill };

// From the start of all processes to their end.
class Life {
 public:
  Life(const HarnessOptions& options, const Setting& setting, MemoryStorage& storage, std::mt19937_64& rng)
      : options_(options), setting_(setting), storage_(storage), rng_(rng), truth_(options.memory_faults) {}

  Outcome live(End end, std::uint64_t end_at) {
    Owner owner;
    DeterministicConfig config;
    caf::actor_system system(config);
    auto& scheduler = dynamic_cast<SeededScheduler&>(system.scheduler());
    Outcome outcome;
    NetworkState network_state{0, options_.memory_faults};
    const NetworkHandle network = system.spawn<Network>(network_state, options_.trace, rng_(), setting_.patience);
    const auto source = std::make_shared<MemoryParts>(setting_, storage_, truth_);
    std::vector<NodeHandle> nodes;
    const auto spawn = [&](NodeId home) {
      const Turn ours(options_.memory_faults, false);
      NodeOptions node;
      node.memory_bytes = ~std::uint64_t{0};
      node.progress_interval = std::chrono::hours(24);
      node.hooks = {options_.trace, network, home};
      nodes.push_back(system.spawn<NodeActor>(std::move(node), source));
      return nodes.back();
    };
    for (std::uint32_t n = 0; n < setting_.nodes; ++n) spawn(NodeId{n});
    Losses losses(options_.faults, setting_.nodes, rng_);
    scheduler.run_all();  // from here on nodes and network wait for messages
    CoordinatorOptions job;
    job.spec = setting_.spec;
    job.mark_settled = [this](bool settled) -> Status {
      storage_.settled = settled;
      if (!settled) storage_.forget_settled();
      return success();
    };
    for (std::uint32_t t = 0; t < setting_.tiles.size(); ++t) {
      job.points.push_back(setting_.tiles[t].size());
      if (!setting_.tiles[t].empty()) job.order.push_back(TileId{t});
    }
    job.on_quiet = [&](const Table& table) {
      const Turn ours(options_.memory_faults, false);
      tell("coordinator: quiet");
      outcome.epochs = table.epoch;
      if (const auto under_way = truth_.under_way(table); under_way != 0) {
        outcome.failure = "quiescence believed with " + std::to_string(under_way) + " updates not processed";
      }
    };
    storage_.take_reads();
    const auto coordinator = system.spawn<Coordinator>(std::move(job), owner, nodes);
    while (outcome.failure.empty() && outcome.steps < steps_max) {
      if (end != End::never && outcome.steps == end_at) {
        tell(end == End::kill ? "killed" : "cancelled");
        if (end == End::kill) break;
        caf::anon_send(coordinator, Cancel{});
      }
      losses.at(outcome.steps, scheduler, coordinator, spawn, options_.trace);
      // A store may end at any moment, or when nothing else is left to happen.
      if (rng_() % 16 == 0 && storage_.store_one(rng_)) continue;
      if (!step(scheduler, outcome) && !storage_.store_one(rng_)) {
        if (owner.end() || !losses.next_step()) break;
        outcome.steps = std::max(outcome.steps, *losses.next_step());
        continue;
      }
      ++outcome.steps;
      if (!losses.any() && !truth_.agrees()) outcome.failure = "the counters of the tiles do not tell what is under way";
    }
    outcome.ended = owner.end();
    losses.thaw(scheduler, losses.nodes());
    for (const NodeHandle& node : nodes) caf::anon_send_exit(node, caf::exit_reason::kill);
    caf::anon_send_exit(network, caf::exit_reason::kill);
    caf::anon_send_exit(coordinator, caf::exit_reason::kill);
    nodes.clear();
    do {
      scheduler.run_all();
    } while (storage_.lose_pending());
    outcome.updates = truth_.sent();
    if (outcome.failure.empty() && end != End::kill && !outcome.ended) {
      outcome.failure = "no end after " + std::to_string(outcome.steps) + " steps";
    }
    const bool settled = outcome.ended && !outcome.ended->failure && outcome.ended->waves == 0;  // from the start
    if (settled && !losses.any() && storage_.take_reads() > 1) {
      outcome.failure = "a run that was settled reads what it is built from more than once";
    }
    return outcome;
  }

 private:
  bool step(SeededScheduler& scheduler, Outcome& outcome) {
    const Turn theirs(options_.memory_faults, true);
    try {
      return scheduler.step(rng_);
    } catch (const std::exception& e) {
      const Turn ours(options_.memory_faults, false);
      outcome.failure = std::string("an exception would have ended the process: ") + e.what();
      scheduler.system().await_actors_before_shutdown(false);  // the one that threw is neither dead nor alive
      return true;
    }
  }

  void tell(const char* what) const {
    if (options_.trace) options_.trace(what);
  }

  const HarnessOptions& options_;
  const Setting& setting_;
  MemoryStorage& storage_;
  std::mt19937_64& rng_;
  Truth truth_;
};

StorageFault draw_fault(std::mt19937_64& rng) {
  StorageFault fault;
  fault.call = static_cast<StorageFault::Call>(rng() % 6);
  fault.how = static_cast<StorageFault::How>(rng() % 3);
  fault.countdown = rng() % 12;
  return fault;
}

void run_seed(const HarnessOptions& options, std::uint64_t seed, HarnessReport& report) {
  std::mt19937_64 rng(seed);
  const Setting setting = make_setting(options, seed, rng);
  MemoryStorage storage(options.dimension, setting.tiles);
  storage.late_stores = setting.late_stores;
  storage.memory_faults = options.memory_faults;
  if (options.faults.storage) storage.fault = draw_fault(rng);
  const auto fail = [&](const std::string& failure) {
    report.failed_seed = seed;
    report.failure = failure;
  };
  const auto allocations_failed = [&] { return options.memory_faults ? options.memory_faults->failed() : 0; };
  // The last life is not ended by anybody, and meets no fault.
  const std::uint64_t ends = options.restarts ? 1 + rng() % 2 : 0;
  std::uint64_t lives_max = ends + 3, damages = 0, mended = 0;
  for (std::uint64_t life = 0;; ++life) {
    const End end = life >= ends ? End::never : rng() % 2 == 0 ? End::cancel : End::kill;
    const std::uint64_t failed_before = allocations_failed();
    const Outcome outcome = Life(options, setting, storage, rng).live(end, rng() % 1500);
    const bool out_of_memory = allocations_failed() > failed_before;
    if (out_of_memory) ++lives_max;
    report.steps += outcome.steps;
    report.updates += outcome.updates;
    report.epochs += outcome.epochs;
    if (!outcome.failure.empty()) return fail(outcome.failure);
    if (outcome.ended) {
      report.waves += outcome.ended->waves;
      report.sleeps += outcome.ended->sum.sleeps;
      if (!outcome.ended->failure) break;
      if (outcome.ended->again && ++mended <= damages) {
        ++lives_max;
        continue;
      }
      const auto code = static_cast<Errc>(outcome.ended->failure.code);
      const bool cancelled = end == End::cancel && code == Errc::interrupted;
      const bool faulty = (options.faults.storage && !storage.fault) || (out_of_memory && code == Errc::memory);
      if (!cancelled && !faulty) return fail(outcome.ended->failure.text);
      if (!cancelled) ++report.failures;
    }
    if (life >= lives_max) return fail("a run that was resumed fails again: " + outcome.ended->failure.text);
    ++report.restarts;
    if (storage.settled) ++report.settled_restarts;
    if (options.restarts && rng() % 4 == 0) {
      storage.damage(rng);
      ++damages;
    }
  }
  report.spills += storage.spills();
  report.mended += mended;
  if (storage.holds_mail()) return fail("mail is left on scratch");
  std::vector<TileMesh> meshes;
  for (const auto& [tile, mesh] : storage.meshes()) meshes.push_back(mesh);
  const std::string wrong = difference(global_delaunay(setting.cloud, options.dimension), main_cells(meshes));
  if (!wrong.empty()) return fail(wrong);
  ++report.seeds;
}

}  // namespace

HarnessReport run_harness(const HarnessOptions& options) {
  HarnessReport report;
  for (std::uint64_t seed = options.first_seed; seed <= options.last_seed && !report.failed_seed; ++seed) {
    run_seed(options, seed, report);
  }
  return report;
}

}  // namespace tessera
