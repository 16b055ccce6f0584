// Vectors for arrays of many megabytes. Their memory comes from the memory pool. resize(n) does not initialise new
// elements, so an array that is filled at once is not touched twice. assign(n, value) and resize(n, value) work as
// usual.
#pragma once

#include <cstddef>
#include <new>
#include <type_traits>
#include <utility>
#include <vector>

#include "src/base/memory_pool.h"

namespace tessera {

template <class T>
class PoolAllocator {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  using value_type = T;
  PoolAllocator() = default;
  template <class U>
  PoolAllocator(const PoolAllocator<U>&) {}

  T* allocate(std::size_t n) {
    if (n > std::size_t(-1) / 4 / sizeof(T)) throw std::bad_alloc();
    if (n * sizeof(T) < large) return static_cast<T*>(::operator new(n * sizeof(T)));
    // The mapping is stored in front of the elements, because deallocate() needs it.
    const Mapping mapping = map_memory(n * sizeof(T) + header);
    ::new (static_cast<void*>(mapping.at)) Mapping(mapping);
    return reinterpret_cast<T*>(mapping.at + header);
  }
  void deallocate(T* at, std::size_t n) noexcept {
    if (n * sizeof(T) < large) return ::operator delete(at);
    Mapping mapping = *reinterpret_cast<const Mapping*>(reinterpret_cast<const std::byte*>(at) - header);
    unmap_memory(mapping, n * sizeof(T) + header);
  }

  template <class U, class... Args>
  void construct(U* at, Args&&... args) {
    if constexpr (sizeof...(Args) == 0) {
      ::new (static_cast<void*>(at)) U;
    } else {
      ::new (static_cast<void*>(at)) U(std::forward<Args>(args)...);
    }
  }

  template <class U>
  bool operator==(const PoolAllocator<U>&) const {
    return true;
  }

 private:
  static constexpr std::size_t large = std::size_t{1} << 20, header = 64;
};

template <class T>
using BigVector = std::vector<T, PoolAllocator<T>>;

}  // namespace tessera
