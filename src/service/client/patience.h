// How long to wait for a server that has answered before and is gone.
#pragma once

#include <chrono>
#include <stop_token>

#include "src/base/result.h"

namespace tessera::client {

class Patience {
 public:
  explicit Patience(std::chrono::seconds length) : length_(length) {}
  // Call this when the server has answered.
  void restart();
  // Pauses, longer each time. Errors: `why` when the time is over; interrupted.
  Status wait(const Error& why, const std::stop_token& stop);
  // The same, without a limit.
  Status pause(const std::stop_token& stop);

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds shortest{250}, longest{5000};
  const std::chrono::seconds length_;
  Clock::time_point heard_ = Clock::now();
  std::chrono::milliseconds pause_ = shortest;
};

}  // namespace tessera::client
