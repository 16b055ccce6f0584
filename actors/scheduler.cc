#include "actors/scheduler.h"

#include <utility>

#include "src/base/check.h"

namespace tessera {

void ReadyQueue::push(Schedulable* actor) {
  {
    const std::lock_guard lock(mutex_);
    (last_ ? last_->next_ : first_) = actor;
    last_ = actor;
  }
  filled_.notify_one();
}

void ReadyQueue::push(caf::resumable* stranger) {
  {
    const std::lock_guard lock(mutex_);
    check(strangers_count_ < strangers_.size(), "CAF has few actors of its own");
    strangers_[strangers_count_++] = stranger;
  }
  filled_.notify_one();
}

caf::resumable* ReadyQueue::pop() {
  std::unique_lock lock(mutex_);
  filled_.wait(lock, [&] { return first_ != nullptr || strangers_count_ > 0; });
  return take();
}

caf::resumable* ReadyQueue::try_pop() {
  const std::lock_guard lock(mutex_);
  return take();
}

caf::resumable* ReadyQueue::take() {
  if (first_) {
    Schedulable* const actor = first_;
    first_ = std::exchange(actor->next_, nullptr);
    if (!first_) last_ = nullptr;
    return actor->job_;
  }
  return strangers_count_ > 0 ? strangers_[--strangers_count_] : nullptr;
}

void TwoPools::enqueue(coordinator_data& data, caf::resumable* job, Pool strangers) {
  if (auto* actor = dynamic_cast<Schedulable*>(job)) {
    queue(data, actor->pool_).push(actor);
  } else {
    queue(data, strangers).push(job);
  }
}

}  // namespace tessera
