// Memory for large arrays, used again and again: fresh pages cost 0.4 s a GiB, and several times that in a virtual
// machine whose host has to find them first, which is as much as the work done in them. What one tile gives back the
// next one takes, whatever the thread.
#pragma once

#include <cstddef>
#include <cstdint>

namespace tessera {

// Small pages: for arrays that are gone through in order. In 2D huge pages made the triangulation itself no faster, and
// a virtual machine may take far longer to come by them: 2.2 s a GiB where memory had been idle, against 0.4 s.
enum class Pages : std::uint8_t { huge, small };

struct Mapping {
  std::byte* at = nullptr;
  std::size_t reserved = 0;  // bytes of address space
  std::size_t touched = 0;   // the first ones, at most, that have pages from earlier use
  Pages pages = Pages::huge;
};

// A mapping of at least `bytes`, from the pool if one fits, then with either kind of pages. Content undefined. Throws
// std::bad_alloc.
Mapping map_memory(std::size_t bytes, Pages pages);
// The same memory with at least `bytes`; may move. Throws std::bad_alloc.
void grow_mapping(Mapping& mapping, std::size_t bytes);
// Gives the memory to the pool, of which the first `used` bytes may have been touched.
void unmap_memory(Mapping& mapping, std::size_t used) noexcept;
// How many touched bytes the pool may keep; what is above goes back to the system at once. 256 MiB at first.
void limit_memory_pool(std::size_t bytes);
// Gives the pages behind the first `kept` of `used` bytes back to the system.
void shrink_mapping(Mapping& mapping, std::size_t kept, std::size_t used) noexcept;
// Gives the whole pages among the first `bytes` back to the system.
void release_pages(const Mapping& mapping, std::size_t bytes) noexcept;

}  // namespace tessera
