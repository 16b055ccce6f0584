// Memory that runs out in the middle of a run: what the harness must be told of it, and tells.
#pragma once

#include <cstdint>

namespace tessera {

class MemoryFaults {
 public:
  virtual ~MemoryFaults() = default;
  // Whose code runs from now on: that under test, or the harness's own, which always has memory. Returns whose ran.
  virtual bool under_test(bool now) = 0;
  // How many allocations have failed so far.
  virtual std::uint64_t failed() const = 0;
};

// For a while it is the turn of the code under test, or of the harness.
class Turn {
 public:
  Turn(MemoryFaults* faults, bool under_test)
      : faults_(faults), before_(faults != nullptr && faults->under_test(under_test)) {}
  ~Turn() {
    if (faults_) faults_->under_test(before_);
  }
  Turn(const Turn&) = delete;
  Turn& operator=(const Turn&) = delete;

 private:
  MemoryFaults* faults_;
  bool before_;
};

}  // namespace tessera
