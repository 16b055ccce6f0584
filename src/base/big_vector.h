// Vectors for arrays of many megabytes. They ask for huge pages: page faults cost 0.4 s a GiB with small ones, a
// quarter of it with huge ones. Unlike std::vector's, their new elements are not initialised by resize(n): what is
// filled at once need not be touched twice. assign(n, value) and resize(n, value) are as usual.
#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <cstdlib>
#include <new>
#include <type_traits>
#include <utility>
#include <vector>

namespace tessera {

template <class T>
class HugePageAllocator {
 public:
  using value_type = T;
  HugePageAllocator() = default;
  template <class U>
  HugePageAllocator(const HugePageAllocator<U>&) {}

  T* allocate(std::size_t n) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (n > std::size_t(-1) / 2 / sizeof(T)) throw std::bad_alloc();
    const std::size_t bytes = n * sizeof(T);
    if (bytes < large) return static_cast<T*>(::operator new(bytes));
    const std::size_t rounded = (bytes + huge_page - 1) / huge_page * huge_page;
    void* memory = std::aligned_alloc(huge_page, rounded);
    if (memory == nullptr) throw std::bad_alloc();
    ::madvise(memory, rounded, MADV_HUGEPAGE);  // a hint: without huge pages it is only slower
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, std::size_t n) { n * sizeof(T) < large ? ::operator delete(memory) : std::free(memory); }

  template <class U, class... Args>
  void construct(U* at, Args&&... args) {
    if constexpr (sizeof...(Args) == 0) {
      ::new (static_cast<void*>(at)) U;
    } else {
      ::new (static_cast<void*>(at)) U(std::forward<Args>(args)...);
    }
  }

  template <class U>
  bool operator==(const HugePageAllocator<U>&) const {
    return true;
  }

 private:
  static constexpr std::size_t huge_page = std::size_t{1} << 21, large = 4 * huge_page;
};

template <class T>
using BigVector = std::vector<T, HugePageAllocator<T>>;

}  // namespace tessera
