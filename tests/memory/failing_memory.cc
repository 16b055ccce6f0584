#include "tests/memory/failing_memory.h"

#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstdlib>
#include <new>
#include <utility>

namespace tessera::testing {
namespace {

std::atomic<bool> armed{false};
std::atomic<std::uint64_t> asked{0}, failed{0}, first_to_fail{0}, last_to_fail{0};
thread_local bool exempt = false;

bool refused() {
  if (!armed.load(std::memory_order_relaxed) || exempt) return false;
  const std::uint64_t now = ++asked;
  if (now < first_to_fail || now > last_to_fail) return false;
  ++failed;
  return true;
}

void* allocate(std::size_t bytes, std::size_t alignment) noexcept {
  if (refused()) return nullptr;
  if (bytes == 0) bytes = 1;
  void* at = nullptr;
  if (alignment <= __STDCPP_DEFAULT_NEW_ALIGNMENT__) {
    at = std::malloc(bytes);
  } else if (posix_memalign(&at, alignment, bytes) != 0) {
    at = nullptr;
  }
  return at;
}

void* allocate_or_throw(std::size_t bytes, std::size_t alignment) {
  void* at = allocate(bytes, alignment);
  if (at == nullptr) throw std::bad_alloc();
  return at;
}

}  // namespace

void fail(std::uint64_t first, std::uint64_t count) {
  asked = failed = 0;
  first_to_fail = first;
  last_to_fail = first + count - 1;
  if (count == 0) last_to_fail = 0;
  armed = true;
}

Allocations so_far() { return {asked, failed}; }

Allocations recover() {
  armed = false;
  return so_far();
}

bool set_exempt(bool now) { return std::exchange(exempt, now); }

}  // namespace tessera::testing

namespace {
using tessera::testing::allocate;
using tessera::testing::allocate_or_throw;
constexpr std::size_t usual = __STDCPP_DEFAULT_NEW_ALIGNMENT__;
constexpr std::size_t size_of(std::align_val_t alignment) { return static_cast<std::size_t>(alignment); }
}  // namespace

void* operator new(std::size_t bytes) { return allocate_or_throw(bytes, usual); }
void* operator new[](std::size_t bytes) { return allocate_or_throw(bytes, usual); }
void* operator new(std::size_t bytes, std::align_val_t to) { return allocate_or_throw(bytes, size_of(to)); }
void* operator new[](std::size_t bytes, std::align_val_t to) { return allocate_or_throw(bytes, size_of(to)); }
void* operator new(std::size_t bytes, const std::nothrow_t&) noexcept { return allocate(bytes, usual); }
void* operator new[](std::size_t bytes, const std::nothrow_t&) noexcept { return allocate(bytes, usual); }
void* operator new(std::size_t bytes, std::align_val_t to, const std::nothrow_t&) noexcept {
  return allocate(bytes, size_of(to));
}
void* operator new[](std::size_t bytes, std::align_val_t to, const std::nothrow_t&) noexcept {
  return allocate(bytes, size_of(to));
}

void operator delete(void* at) noexcept { std::free(at); }
void operator delete[](void* at) noexcept { std::free(at); }
void operator delete(void* at, std::size_t) noexcept { std::free(at); }
void operator delete[](void* at, std::size_t) noexcept { std::free(at); }
void operator delete(void* at, std::align_val_t) noexcept { std::free(at); }
void operator delete[](void* at, std::align_val_t) noexcept { std::free(at); }
void operator delete(void* at, std::size_t, std::align_val_t) noexcept { std::free(at); }
void operator delete[](void* at, std::size_t, std::align_val_t) noexcept { std::free(at); }
void operator delete(void* at, const std::nothrow_t&) noexcept { std::free(at); }
void operator delete[](void* at, const std::nothrow_t&) noexcept { std::free(at); }
void operator delete(void* at, std::align_val_t, const std::nothrow_t&) noexcept { std::free(at); }
void operator delete[](void* at, std::align_val_t, const std::nothrow_t&) noexcept { std::free(at); }

// In place of the C library's, for what calls them by name: this program's own code.
extern "C" {

void* mmap(void* at, std::size_t bytes, int protection, int flags, int file, off_t offset) noexcept {
  if ((flags & MAP_ANONYMOUS) != 0 && tessera::testing::refused()) {
    errno = ENOMEM;
    return MAP_FAILED;
  }
  return reinterpret_cast<void*>(syscall(SYS_mmap, at, bytes, protection, flags, file, offset));
}

void* mremap(void* at, std::size_t bytes, std::size_t wanted, int flags, ...) noexcept {
  if (tessera::testing::refused()) {
    errno = ENOMEM;
    return MAP_FAILED;
  }
  va_list rest;
  va_start(rest, flags);
  void* to = (flags & MREMAP_FIXED) != 0 ? va_arg(rest, void*) : nullptr;
  va_end(rest);
  return reinterpret_cast<void*>(syscall(SYS_mremap, at, bytes, wanted, flags, to));
}

void* aligned_alloc(std::size_t alignment, std::size_t bytes) noexcept { return allocate(bytes, alignment); }

}  // extern "C"
