// Gives free memory in the allocator's pools back to the system. Work leaves such memory behind in pools of its thread,
// where other threads cannot use it.
#pragma once

#include <malloc.h>

#include <atomic>
#include <cstdint>

namespace tessera {

// Trims the heap once for each `often` bytes that were worked on. Trimming takes time in proportion to the size of the
// pools, whatever is free in them. So small tiles would otherwise pay more for trimming than for their work.
class HeapTrim {
 public:
  // Sets after how many bytes of work the heap is trimmed. 0: never. Not thread-safe.
  void set_often(std::uint64_t bytes) { often_ = bytes; }
  // Counts `bytes` of work, and trims the heap when it is time. Thread-safe.
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
