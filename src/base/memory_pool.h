// Memory for large arrays, used again and again: fresh pages cost 0.4 s a GiB, and several times that in a virtual
// machine whose host has to find them first, which is as much as the work done in them. What one tile gives back the
// next one takes, whatever the thread.
#pragma once

#include <cstddef>

namespace tessera {

struct Mapping {
  std::byte* at = nullptr;
  std::size_t reserved = 0;  // bytes of address space
  std::size_t touched = 0;   // the first ones, at most, that have pages from earlier use
};

// A mapping of at least `bytes`, from the pool if one fits. Content undefined. Throws std::bad_alloc.
Mapping map_memory(std::size_t bytes);
// The same memory with at least `bytes`; may move. Throws std::bad_alloc.
void grow_mapping(Mapping& mapping, std::size_t bytes);
// Gives the memory to the pool, of which the first `used` bytes may have been touched.
void unmap_memory(Mapping& mapping, std::size_t used) noexcept;
// While there is one, the pool keeps as many touched bytes as all of these ask for; what is above goes back to the
// system at once. Without any it keeps 256 MiB.
class MemoryPoolShare {
 public:
  explicit MemoryPoolShare(std::size_t bytes);
  ~MemoryPoolShare();
  MemoryPoolShare(const MemoryPoolShare&) = delete;
  MemoryPoolShare& operator=(const MemoryPoolShare&) = delete;

 private:
  std::size_t bytes_;
};
// Gives the pages behind the first `kept` of `used` bytes back to the system.
void shrink_mapping(Mapping& mapping, std::size_t kept, std::size_t used) noexcept;

}  // namespace tessera
