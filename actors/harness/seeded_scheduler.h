// Runs actors one message at a time, in a random order. Takes no memory while it does so.
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

  // Has a random ready actor handle one message. Returns false when none is ready.
  bool step(std::mt19937_64& rng);
  // Leaves out the actors of a home, because its process has stopped or is gone. thaw() takes that back.
  void freeze(NodeId home) { frozen_.insert(home); }
  void thaw(NodeId home) { frozen_.erase(home); }
  void thaw() { frozen_.clear(); }
  // Runs until no actor is ready, frozen ones included.
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
