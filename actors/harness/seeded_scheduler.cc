#include "actors/harness/seeded_scheduler.h"

#include <algorithm>

#include "actors/scheduler.h"
#include "src/base/check.h"

namespace tessera {
namespace {

constexpr std::size_t actors_max = 10'000;

}  // namespace

class SeededScheduler::Worker final : public caf::execution_unit {
 public:
  explicit Worker(SeededScheduler& scheduler) : execution_unit(&scheduler.system()), scheduler_(scheduler) {}
  void exec_later(caf::resumable* job) override { scheduler_.enqueue(job); }

 private:
  SeededScheduler& scheduler_;
};

SeededScheduler::SeededScheduler(caf::actor_system& system) : test_coordinator(system) { ready_.reserve(actors_max); }

void SeededScheduler::enqueue(caf::resumable* job) {
  check(ready_.size() < actors_max, "a harness has few actors");
  ready_.push_back(job);
}

bool SeededScheduler::step(std::mt19937_64& rng) {
  if (frozen_.empty()) {
    if (ready_.empty()) return false;
    resume(rng() % ready_.size());
    return true;
  }
  const auto running = static_cast<std::size_t>(
      std::count_if(ready_.begin(), ready_.end(), [&](const caf::resumable* job) { return runs(job); }));
  if (running == 0) return false;
  std::size_t left = rng() % running;
  for (std::size_t i = 0;; ++i) {
    if (runs(ready_[i]) && left-- == 0) {
      resume(i);
      return true;
    }
  }
}

bool SeededScheduler::runs(const caf::resumable* job) const {
  const auto* actor = dynamic_cast<const Schedulable*>(job);
  return !actor || !actor->home() || !frozen_.contains(*actor->home());
}

void SeededScheduler::run_all() {
  while (!ready_.empty()) resume(0);
}

void SeededScheduler::resume(std::size_t chosen) {
  caf::resumable* const job = ready_[chosen];
  ready_.erase(ready_.begin() + static_cast<std::ptrdiff_t>(chosen));
  Worker worker(*this);
  switch (job->resume(&worker, 1)) {
    case caf::resumable::resume_later:
      return enqueue(job);
    case caf::resumable::done:
    case caf::resumable::awaiting_message:
      return caf::intrusive_ptr_release(job);
    case caf::resumable::shutdown_execution_unit:
      return;
  }
}

}  // namespace tessera
