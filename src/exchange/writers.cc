#include "src/exchange/writers.h"

#include <utility>

namespace tessera {

Writers::Writers(std::uint32_t threads) {
  try {
    for (std::uint32_t t = 0; t < threads; ++t) threads_.emplace_back([this] { work(); });
  } catch (...) {
    stop();  // the threads that were started wait for tasks
    throw;
  }
}

Writers::~Writers() { stop(); }

void Writers::take(Task task) {
  {
    const std::lock_guard lock(mutex_);
    waiting_.push_back(std::move(task));
  }
  changed_.notify_one();
}

void Writers::work() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return stopped_ || !waiting_.empty(); });
    if (waiting_.empty()) return;
    Task task = std::move(waiting_.front());
    waiting_.pop_front();
    lock.unlock();
    task();
    task = nullptr;
    lock.lock();
  }
}

void Writers::stop() noexcept {
  {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
  }
  changed_.notify_all();
  threads_.clear();
}

}  // namespace tessera
