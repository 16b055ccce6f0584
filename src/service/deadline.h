// The end of what a caller waits for.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <stop_token>
#include <thread>

#include "src/base/ledger.h"

namespace tessera {

// Stops the work on a ledger when its time is over, with this reason, unless it dies before.
class Deadline {
 public:
  // The ledger outlives this.
  Deadline(Ledger& ledger, std::chrono::seconds time, Error over);

 private:
  std::mutex mutex_;
  std::condition_variable_any ended_;
  std::jthread timer_;  // the last member: it ends first
};

// What a request may take whose caller waits for the answer, on the thread that answers it. A job has other bounds.
class WhileAnyoneWaits {
 public:
  // Of `inputs`: names of files that are looked at, matched by a pattern or not.
  static constexpr std::uint64_t names_max = 100'000;
  // `gone`: stopped when the caller is not there any more.
  explicit WhileAnyoneWaits(const std::stop_token& gone);
  Ledger& ledger() { return ledger_; }

 private:
  Ledger ledger_;
  Deadline deadline_;
  std::stop_callback<std::function<void()>> when_gone_;
  Ledger::Use use_;
};

// The time that an answer may take; and what who asked for more is told.
inline constexpr std::chrono::seconds answer_time{60};
Error time_is_over(std::chrono::seconds time);

}  // namespace tessera
