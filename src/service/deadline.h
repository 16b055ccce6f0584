// Limits how long a request may take.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <stop_token>
#include <thread>

#include "src/base/ledger.h"

namespace tessera::service {

// Stops the work on a ledger with the reason `over` after `time`, unless the Deadline is destroyed before.
class Deadline {
 public:
  // The ledger must stay valid as long as this object.
  Deadline(Ledger& ledger, std::chrono::seconds time, Error over);

 private:
  std::mutex mutex_;
  std::condition_variable_any ended_;
  std::jthread timer_;  // the last member: it ends first
};

// The bounds of a request that is answered while its caller waits, on the thread that answers it. Jobs have other
// bounds.
class WhileAnyoneWaits {
 public:
  // The most names of files that a request's `inputs` may look at, whether a pattern matches them or not.
  static constexpr std::uint64_t names_max = 100'000;
  // A stop of `gone` means that the caller has gone.
  explicit WhileAnyoneWaits(const std::stop_token& gone);
  Ledger& ledger() { return ledger_; }

 private:
  Ledger ledger_;
  Deadline deadline_;
  std::stop_callback<std::function<void()>> when_gone_;
  Ledger::Use use_;
};

// The time that an answer may take, and the error of a request that takes longer.
inline constexpr std::chrono::seconds answer_time{60};
Error time_is_over(std::chrono::seconds time);

}  // namespace tessera::service
