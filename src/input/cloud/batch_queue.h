// A queue of a few batches between a thread that reads them and a thread that uses them.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "src/input/cloud/cloud.h"

namespace tessera {

class BatchQueue {
 public:
  // Waits for room and takes the content of `batch`. Gives `batch` the memory of a batch that is no longer used.
  // Returns false once the queue is closed.
  bool push(CloudBatch& batch) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return closed_ || waiting_.size() < waiting_max; });
    if (closed_) return false;
    waiting_.push_back(std::move(batch));
    batch = {};
    if (!spare_.empty()) {
      batch = std::move(spare_.back());
      spare_.pop_back();
    }
    changed_.notify_all();
    return true;
  }
  // Says that no batch follows, because of the end or an error.
  void finish(Status status) {
    const std::lock_guard lock(mutex_);
    end_.emplace(std::move(status));
    changed_.notify_all();
  }
  // Waits for the next batch and takes back the memory of the last one. Returns false at the end; then status() says
  // why.
  bool pop(CloudBatch& batch) {
    std::unique_lock lock(mutex_);
    if (batch.points.capacity() > 0) spare_.push_back(std::move(batch));
    changed_.wait(lock, [&] { return end_ || !waiting_.empty(); });
    if (waiting_.empty()) return false;
    batch = std::move(waiting_.front());
    waiting_.pop_front();
    changed_.notify_all();
    return true;
  }
  // REQUIRES: pop() has returned false.
  const Status& status() const { return *end_; }
  // Says that no more batches are popped.
  void close() {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    changed_.notify_all();
  }

 private:
  static constexpr std::size_t waiting_max = 4;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<CloudBatch> waiting_;
  std::vector<CloudBatch> spare_;
  std::optional<Status> end_;
  bool closed_ = false;
};

}  // namespace tessera
