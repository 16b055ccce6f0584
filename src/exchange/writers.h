// Threads that store what tiles leave, so that others need not wait for the disk.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace tessera {

class Writers {
 public:
  using Task = std::function<void()>;  // does not throw

  // Throws what a thread that cannot be started throws; none is left then.
  explicit Writers(std::uint32_t threads);
  // Waits for all tasks.
  ~Writers();
  Writers(const Writers&) = delete;
  Writers& operator=(const Writers&) = delete;

  // Has it done by the next thread that is free.
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
