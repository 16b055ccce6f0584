// How long a server that was there and is gone is waited for.
#pragma once

#include <chrono>
#include <stop_token>

#include "src/base/result.h"

namespace tessera {

class Patience {
 public:
  explicit Patience(std::chrono::seconds length) : length_(length) {}
  // The server has been heard.
  void restart();
  // A pause, longer each time. Errors: `why` when the patience has come to its end, interrupted.
  Status wait(const Error& why, const std::stop_token& stop);
  // The same without an end.
  Status pause(const std::stop_token& stop);

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds shortest{250}, longest{5000};
  const std::chrono::seconds length_;
  Clock::time_point heard_ = Clock::now();
  std::chrono::milliseconds pause_ = shortest;
};

}  // namespace tessera
