// One life of a run: all its processes from their start to their end, and the faults that befall them.
#pragma once

#include <caf/all.hpp>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "actors/coordinator.h"
#include "actors/harness/losses.h"
#include "actors/harness/memory_storage.h"
#include "actors/harness/network.h"
#include "actors/harness/seeded_scheduler.h"
#include "actors/harness/setting.h"
#include "actors/harness/truth.h"
#include "actors/run_owner.h"

namespace tessera {

struct Outcome {
  std::string failure;  // of the harness: something that must not happen
  std::optional<RunEnded> ended;
  std::uint64_t steps = 0, updates = 0, epochs = 0;
};

// How a life ends early.
enum class End : std::uint8_t { never, cancel, kill };

// A run of all processes under one scheduler. Used once.
class Life final : private Misfortune {
 public:
  // All arguments outlive this object.
  Life(const HarnessOptions& options, const Setting& setting, MemoryStorage& storage, LaterStages* later,
       std::mt19937_64& rng);
  // Runs until the run has ended, or until the step `end_at`, at which it is cancelled or killed as `end` says. Called
  // once.
  Outcome live(End end, std::uint64_t end_at);

 private:
  class Owner final : public RunOwner {
   public:
    void progressed(const RunProgress&) override {}
    void said(const std::string&) override {}
    void stored(const TileDone&) override {}
    void ended(RunEnded end) noexcept override { end_ = std::move(end); }
    const std::optional<RunEnded>& end() const { return end_; }

   private:
    std::optional<RunEnded> end_;
  };
  // The actor that the coordinator tells that a node may go.
  class Usher final : public UsherHandle::base {
   public:
    Usher(caf::actor_config& config, Life& life) : UsherHandle::base(config), life_(life) {}
    behavior_type make_behavior() override {
      return {[this](const NodeLet& let) { life_.let(let); }};
    }

   private:
    Life& life_;
  };
  class Config : public caf::actor_system_config {
   public:
    Config();
  };

  void stop(NodeId node) override;
  void go_on(NodeId node) override;
  void give_up(NodeId node) override;
  void join(NodeId node) override;
  void leave(NodeId node) override;
  void join_in_vain(NodeId node) override;
  void lose(NodeId node) override;
  void stop_coordinator() override;
  void take_over() override;
  void coordinators_go_on() override;

  void add_node(NodeId home, std::uint64_t memory_bytes = ~std::uint64_t{0});
  void tell_of(NodeId node);
  std::vector<ExchangeWatch*> watches();
  std::uint32_t first_stage() const;
  void tell_that_leaves(NodeId node);
  void let(const NodeLet& let);
  void add_coordinator();
  CoordinatorOptions coordinator_options();
  void believed_quiet(const RoutingTable& table);
  bool step();
  bool nobody_is_left() const;  // no node is left that works, or could work
  void end_all();
  const std::optional<RunEnded>& ended() const;
  void tell(const std::string& what) const;

  const HarnessOptions& options_;
  const Setting& setting_;
  MemoryStorage& storage_;
  LaterStages* later_;  // null: there are no later stages
  std::mt19937_64& rng_;
  std::vector<Truth> truths_;  // by stage
  NetworkState network_state_;
  Outcome outcome_;
  std::vector<std::unique_ptr<Owner>> owners_;  // one for each coordinator
  Config config_;
  caf::actor_system system_;
  SeededScheduler& scheduler_;
  NetworkHandle network_;
  UsherHandle usher_;
  std::map<NodeId, NodeHandle> nodes_;
  std::set<NodeId> given_up_;  // also nodes that no coordinator begins with
  std::set<NodeId> leaving_;   // of the other nodes; each coordinator is told of them
  // The present coordinator began without nodes. It is not told of nodes that cannot be used, because such a node
  // would be the only one that it has.
  bool began_alone_ = false;
  std::vector<CoordinatorHandle> coordinators_;  // the last one is the present one
};

}  // namespace tessera
