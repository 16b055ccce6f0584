// Shows a job's Progress while it works, from a thread of its own.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "src/base/progress.h"
#include "src/job/report/progress_line.h"

namespace tessera {

enum class ProgressStyle : std::uint8_t {
  none,      // nothing at all
  terminal,  // lines redrawn in place, five times a second
  lines,     // a line when the phase changes, and every five seconds
  json,      // one object a line when the phase changes, and every second
};

class ProgressDisplay {
 public:
  // Writes to `out` until stop() or destruction. `elapsed_before_s`: how long the job has worked already. REQUIRES:
  // `progress` and `out` outlive this object.
  ProgressDisplay(const Progress& progress, ProgressStyle style, std::FILE* out, double elapsed_before_s = 0);
  ~ProgressDisplay();
  ProgressDisplay(const ProgressDisplay&) = delete;
  ProgressDisplay& operator=(const ProgressDisplay&) = delete;

  // Removes the panel from the terminal, so that the next output starts on a clean line. Idempotent.
  void stop();
  double elapsed_s() const;

 private:
  void run(const std::stop_token& stop);
  void show(const ProgressSnapshot& now);
  void erase_panel();

  const Progress& progress_;
  const ProgressStyle style_;
  std::FILE* const out_;
  const std::chrono::steady_clock::time_point start_;
  ProgressSnapshot before_;
  Phase shown_phase_ = {};
  double shown_s_ = -1;
  int panel_lines_ = 0;
  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::jthread thread_;  // last: it uses all of the above
};

}  // namespace tessera
