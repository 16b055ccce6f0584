// The thread that looks after jobs twice a second: tells their progress, writes records that could not be written, and
// forgets old jobs.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <thread>

#include "src/service/jobs/job_table.h"

namespace tessera::service {

struct UpkeepOptions {
  std::chrono::seconds retention{0};  // ended jobs are forgotten after it; 0: never
  // How many tiles of a job outlive the process.
  std::function<std::uint64_t(const Progress&)> lasting;
  // Called once a minute; may be empty.
  std::function<void()> each_minute;
};

class Upkeep {
 public:
  Upkeep(JobTable& table, UpkeepOptions options);
  ~Upkeep();
  Upkeep(const Upkeep&) = delete;
  Upkeep& operator=(const Upkeep&) = delete;

  // How long the thread has been silent. It is silent for long only when a disk does not answer.
  std::chrono::steady_clock::duration silence() const;

 private:
  void run();

  JobTable& table_;
  const UpkeepOptions options_;
  mutable std::mutex mutex_;
  std::condition_variable ended_;
  bool ending_ = false;
  std::chrono::steady_clock::time_point seen_ = std::chrono::steady_clock::now();
  std::thread thread_;
};

}  // namespace tessera::service
