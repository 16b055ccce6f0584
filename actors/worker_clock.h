// Times a piece of work on the thread that does it, for the report's timeline.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>

#include "src/base/ids.h"
#include "src/base/progress.h"

namespace tessera {

class WorkSpan {
 public:
  WorkSpan(Progress* progress, Phase phase, TileId tile)
      : progress_(progress), phase_(phase), tile_(tile), begin_(std::chrono::steady_clock::now()) {}
  WorkSpan(const WorkSpan&) = delete;
  WorkSpan& operator=(const WorkSpan&) = delete;
  ~WorkSpan() {
    if (!progress_) return;
    const auto seconds = [&](auto t) { return std::chrono::duration<double>(t - progress_->started).count(); };
    progress_->add_span(
        {phase_, tile_.value, thread_number(), seconds(begin_), seconds(std::chrono::steady_clock::now())});
  }
  std::uint64_t microseconds() const {
    return static_cast<std::uint64_t>(
        std::chrono::duration_cast<std::chrono::microseconds>(std::chrono::steady_clock::now() - begin_).count());
  }

 private:
  // Threads in the order in which they first did any work.
  static std::uint32_t thread_number() {
    static std::atomic<std::uint32_t> next{0};
    thread_local const std::uint32_t number = next++;
    return number;
  }

  Progress* progress_;
  Phase phase_;
  TileId tile_;
  std::chrono::steady_clock::time_point begin_;
};

}  // namespace tessera
