// An exception that ends long work when the work is asked to stop. The unfinished result of such work is useless.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <stop_token>
#include <utility>

namespace tessera {

struct Stopped : std::runtime_error {
  Stopped() : std::runtime_error("stopped in the middle of its work") {}
};

inline void throw_if_stopped(const std::stop_token& stop) {
  if (stop.stop_requested()) throw Stopped();
}

// For loops of short steps: looks at the token once in `steps_a_look` steps, and throws Stopped.
class StopCheck {
 public:
  StopCheck(std::stop_token stop, std::uint32_t steps_a_look)
      : stop_(std::move(stop)), steps_a_look_(steps_a_look), left_(steps_a_look) {}

  void step() {
    if (--left_ != 0) return;
    left_ = steps_a_look_;
    throw_if_stopped(stop_);
  }

 private:
  std::stop_token stop_;
  std::uint32_t steps_a_look_, left_;
};

}  // namespace tessera
