// A pool of memory for large arrays. Fresh pages cost 0.4 s a GiB, and several times that in a virtual machine whose
// host must find them first. That is as much as the work done in them. So the next tile takes the memory that a tile
// gives back, in whatever thread.
#pragma once

#include <cstddef>

namespace tessera {

// A piece of memory.
struct Mapping {
  std::byte* at = nullptr;
  std::size_t reserved = 0;  // bytes of address space
  std::size_t touched = 0;   // at most this many of the first bytes have pages from earlier use
};

// Returns a mapping of at least `bytes`, from the pool if one there fits. The content is undefined. Throws
// std::bad_alloc.
Mapping map_memory(std::size_t bytes);
// Grows a mapping to at least `bytes` and keeps its content. The mapping may move. Throws std::bad_alloc.
void grow_mapping(Mapping& mapping, std::size_t bytes);
// Gives a mapping back to the pool. `used` says how many of its first bytes may have been touched.
void unmap_memory(Mapping& mapping, std::size_t used) noexcept;
// A share of the memory that the pool keeps. The pool keeps as many touched bytes as all shares together ask for, and
// returns the rest to the system at once. While there is no share the pool keeps 256 MiB.
class MemoryPoolShare {
 public:
  explicit MemoryPoolShare(std::size_t bytes);
  ~MemoryPoolShare();
  MemoryPoolShare(const MemoryPoolShare&) = delete;
  MemoryPoolShare& operator=(const MemoryPoolShare&) = delete;

 private:
  std::size_t bytes_;
};
// Returns to the system the pages between the first `kept` and the first `used` bytes.
void shrink_mapping(Mapping& mapping, std::size_t kept, std::size_t used) noexcept;

}  // namespace tessera
