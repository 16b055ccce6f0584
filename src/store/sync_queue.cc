#include "src/store/sync_queue.h"

#include <utility>

#include "src/store/manifest.h"

namespace tessera::store {

SyncQueue& SyncQueue::instance() {
  static SyncQueue queue;
  return queue;
}

SyncQueue::~SyncQueue() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void SyncQueue::push(const std::filesystem::path& out, TemporaryFile file, const TileEntry& entry) {
  {
    const std::lock_guard lock(mutex_);
    if (!thread_.joinable()) thread_ = std::thread([this] { work(); });
    jobs_.push_back({out.string(), std::move(file), entry});
    ++unfinished_[out.string()];
  }
  changed_.notify_all();
}

Status SyncQueue::settle(const std::filesystem::path& out) {
  const auto key = out.string();
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return !unfinished_.contains(key); });
  if (const auto found = errors_.find(key); found != errors_.end()) {
    Error first = std::move(found->second);
    errors_.erase(found);
    return first;
  }
  return success();
}

Status SyncQueue::failed(const std::filesystem::path& out) {
  const std::lock_guard lock(mutex_);
  if (const auto found = errors_.find(out.string()); found != errors_.end()) return found->second;
  return success();
}

void SyncQueue::work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [&] { return stopping_ || !jobs_.empty(); });
    if (jobs_.empty()) return;  // stopping, and nothing left to make durable
    Job job = std::move(jobs_.front());
    jobs_.pop_front();
    lock.unlock();

    const TileId tile{job.entry.tile};
    Status status = publish(job.file.path(), tile_file(job.out, tile));
    if (status) {
      job.file.keep();
      status = write_done(job.out, job.entry);
    }

    lock.lock();
    if (!status) errors_.try_emplace(job.out, status.error());
    if (const auto left = unfinished_.find(job.out); --left->second == 0) unfinished_.erase(left);
    changed_.notify_all();
  }
}

}  // namespace tessera::store
