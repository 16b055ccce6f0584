// Threads that store what tiles leave, so that other threads need not wait for the disk.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace tessera {

// A pool of threads that run tasks in the order in which they came. take() may be called from any thread.
class Writers {
 public:
  using Task = std::function<void()>;  // does not throw

  // Starts `threads` threads. Throws std::system_error when one cannot be started; then none is left.
  explicit Writers(std::uint32_t threads);
  // Waits for all tasks.
  ~Writers();
  Writers(const Writers&) = delete;
  Writers& operator=(const Writers&) = delete;

  // Has the next free thread run the task.
  void take(Task task);

 private:
  void work();
  void stop() noexcept;

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Task> waiting_;
  bool stopped_ = false;
  std::vector<std::jthread> threads_;
};

}  // namespace tessera
