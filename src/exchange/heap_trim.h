// What work has left behind in the allocator's pools, where no other thread finds it, goes back to the system.
#pragma once

#include <malloc.h>

#include <atomic>
#include <cstdint>

namespace tessera {

// Going through the pools takes as long as they are large, whatever is found there: once for each `often` bytes that
// were worked on, so that small tiles do not pay more for it than for their work.
class HeapTrim {
 public:
  // 0: never.
  void set_often(std::uint64_t bytes) { often_ = bytes; }
  // Called by any thread.
  void worked_on(std::uint64_t bytes) const {
    if (often_ == 0 || (since_ += bytes) < often_) return;
    since_ = 0;
    malloc_trim(0);
  }

 private:
  std::uint64_t often_ = 0;
  mutable std::atomic<std::uint64_t> since_ = 0;
};

}  // namespace tessera
