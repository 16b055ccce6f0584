// Decides which actor runs next, and on which thread. This replaces CAF's own policy, which puts ready actors into a
// list. When there is no memory for an entry of that list, the actor's message is never handled, and the run never
// ends.
#pragma once

#include <array>
#include <caf/all.hpp>
#include <caf/policy/unprofiled.hpp>
#include <caf/scheduler/coordinator.hpp>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>

#include "src/base/ids.h"

namespace tessera {

// Actors that decide what tiles do must not wait until the work of a tile is done. So they have threads of their own,
// which all jobs share.
enum class Pool : std::uint8_t { deciding, tiles };
// Two threads, so that one may read a run folder while the other goes on.
inline constexpr std::size_t deciding_threads = 2;

// Base of an actor. A ready actor stands in one queue at most, so the actor itself is the link of the queue.
class Schedulable {
 public:
  Schedulable(caf::resumable* job, Pool pool) : job_(job), pool_(pool) {}
  virtual ~Schedulable() = default;

  // The process to which the actor would belong, where several simulated processes share one: the harness stops all
  // actors of a home.
  std::optional<NodeId> home() const { return home_; }

 protected:
  void live_at(std::optional<NodeId> home) { home_ = home; }

 private:
  friend class ReadyQueue;
  friend class TwoPools;
  caf::resumable* job_;
  Pool pool_;
  Schedulable* next_ = nullptr;
  std::optional<NodeId> home_;
};

// A queue of ready actors, first come, first served. Thread-safe.
class ReadyQueue {
 public:
  void push(Schedulable* actor);
  // Adds an actor of CAF's own, which CAF has when the system starts and stops. At most 8 may wait.
  void push(caf::resumable* stranger);
  caf::resumable* pop();      // waits until there is one
  caf::resumable* try_pop();  // null when there is none

 private:
  caf::resumable* take();

  std::mutex mutex_;
  std::condition_variable filled_;
  Schedulable* first_ = nullptr;
  Schedulable* last_ = nullptr;
  std::array<caf::resumable*, 8> strangers_{};
  std::size_t strangers_count_ = 0;
};

// The policy of caf::scheduler::coordinator. Its first workers run the deciding actors.
class TwoPools : public caf::policy::unprofiled {
 public:
  struct coordinator_data {
    explicit coordinator_data(caf::scheduler::abstract_coordinator*) {}
    std::array<ReadyQueue, 2> queues;  // by Pool
  };
  struct worker_data {
    explicit worker_data(caf::scheduler::abstract_coordinator*) {}
  };

  template <class Coordinator>
  void central_enqueue(Coordinator* coordinator, caf::resumable* job) {
    enqueue(coordinator->data(), job, Pool::deciding);
  }
  template <class Worker>
  void external_enqueue(Worker* worker, caf::resumable* job) {
    enqueue(worker->parent()->data(), job, pool_of(worker));
  }
  template <class Worker>
  void internal_enqueue(Worker* worker, caf::resumable* job) {
    enqueue(worker->parent()->data(), job, pool_of(worker));
  }
  template <class Worker>
  void resume_job_later(Worker* worker, caf::resumable* job) {
    enqueue(worker->parent()->data(), job, pool_of(worker));
  }
  template <class Worker>
  caf::resumable* dequeue(Worker* worker) {
    return queue(worker->parent()->data(), pool_of(worker)).pop();
  }
  template <class Worker, class Visit>
  void foreach_resumable(Worker*, Visit) {}
  template <class Coordinator, class Visit>
  void foreach_central_resumable(Coordinator* coordinator, Visit visit) {
    for (ReadyQueue& queue : coordinator->data().queues) {
      while (caf::resumable* job = queue.try_pop()) visit(job);
    }
  }

 private:
  template <class Worker>
  static Pool pool_of(Worker* worker) {
    return worker->id() < deciding_threads ? Pool::deciding : Pool::tiles;
  }
  static ReadyQueue& queue(coordinator_data& data, Pool pool) { return data.queues[static_cast<std::size_t>(pool)]; }
  // `strangers` is the pool for actors of CAF's own.
  static void enqueue(coordinator_data& data, caf::resumable* job, Pool strangers);
};

using Scheduler = caf::scheduler::coordinator<TwoPools>;

}  // namespace tessera
