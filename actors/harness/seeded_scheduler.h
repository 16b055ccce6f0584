// Runs actors one message at a time, in an order that is drawn. Needs no memory while it does.
#pragma once

#include <caf/all.hpp>
#include <caf/scheduler/test_coordinator.hpp>
#include <random>
#include <vector>

namespace tessera {

class SeededScheduler final : public caf::scheduler::test_coordinator {
 public:
  explicit SeededScheduler(caf::actor_system& system);

  // Has a random ready actor handle one message. False when none is ready.
  bool step(std::mt19937_64& rng);
  // Goes on until nothing is ready.
  void run_all();

  void enqueue(caf::resumable* job) override;
  void stop() override { run_all(); }

 private:
  class Worker;
  void resume(std::size_t chosen);

  std::vector<caf::resumable*> ready_;
};

}  // namespace tessera
