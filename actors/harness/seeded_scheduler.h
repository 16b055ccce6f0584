// Runs actors one message at a time, in an order that is drawn. Needs no memory while it does.
#pragma once

#include <caf/all.hpp>
#include <caf/scheduler/test_coordinator.hpp>
#include <random>
#include <set>
#include <vector>

#include "src/base/ids.h"

namespace tessera {

class SeededScheduler final : public caf::scheduler::test_coordinator {
 public:
  explicit SeededScheduler(caf::actor_system& system);

  // Has a random ready actor handle one message. False when none is ready.
  bool step(std::mt19937_64& rng);
  // Whether the actors of a home are left out: it has stopped, or is no more.
  void freeze(NodeId home) { frozen_.insert(home); }
  void thaw(NodeId home) { frozen_.erase(home); }
  void thaw() { frozen_.clear(); }
  // Goes on until nothing is ready.
  void run_all();

  void enqueue(caf::resumable* job) override;
  void stop() override { run_all(); }

 private:
  class Worker;
  void resume(std::size_t chosen);
  bool runs(const caf::resumable* job) const;

  std::vector<caf::resumable*> ready_;
  std::set<NodeId> frozen_;
};

}  // namespace tessera
