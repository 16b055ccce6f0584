// Makes memory run out in the middle of a run: the interface between the harness and the test's allocator.
#pragma once

#include <cstdint>

namespace tessera {

class MemoryFaults {
 public:
  virtual ~MemoryFaults() = default;
  // Says which code runs from now on: the code under test, or that of the harness, which always has memory. Returns
  // what was set before.
  virtual bool under_test(bool now) = 0;
  // Returns how many allocations have failed so far.
  virtual std::uint64_t failed() const = 0;
};

// Sets, for its lifetime, whether the code under test or the harness runs. `faults` may be null.
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
