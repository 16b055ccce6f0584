#include "src/base/memory_pool.h"

#include <pthread.h>
#include <sys/mman.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <new>
#include <utility>

namespace tessera {
namespace {

constexpr std::size_t page = 4096;
// Mappings up to this size come from the allocator. The arrays of small tiles would cost more system calls and page
// faults than work, and a process may have only 65,530 mappings.
constexpr std::size_t small_bytes = std::size_t{128} << 10;
constexpr std::size_t alignment = 64;

bool is_small(const Mapping& mapping) { return mapping.reserved <= small_bytes; }

std::size_t rounded(std::size_t bytes) { return (bytes + page - 1) / page * page; }

// Rounds up to address space for `bytes` and some more, which costs nothing. Tiles are of nearly equal sizes. So an
// array a little larger than the last tile's fits into the same mapping.
std::size_t with_room(std::size_t bytes) {
  const std::size_t step = std::max(page, std::bit_floor(bytes) / 4);
  return (bytes + step - 1) / step * step;
}

// The mappings that were given back, the oldest first. give() needs no memory, because it is called when there is none.
class Pool {
 public:
  bool take(std::size_t bytes, Mapping& out) {
    const std::lock_guard lock(mutex_);
    std::size_t best = count_;
    for (std::size_t i = 0; i < count_; ++i) {
      // A mapping that is far too large is not used: a small array would hold the pages of a large one.
      if (kept_[i].reserved < bytes || kept_[i].touched / 4 > bytes) continue;
      const bool better = best == count_ || kept_[i].reserved < kept_[best].reserved ||
                          (kept_[i].reserved == kept_[best].reserved && kept_[i].touched > kept_[best].touched);
      if (better) best = i;
    }
    if (best == count_) return false;
    out = remove(best);
    shrink(out, bytes);  // else the next owner would hold pages behind `bytes` without knowing
    return true;
  }

  void give(const Mapping& mapping) {
    const std::lock_guard lock(mutex_);
    if (count_ == kept_.size()) unmap_oldest();
    kept_[count_++] = mapping;
    held_ += mapping.touched;
    trim();
  }

  void add_share(std::size_t bytes) {
    const std::lock_guard lock(mutex_);
    ++shares_;
    asked_ += bytes;
    trim();
  }

  void remove_share(std::size_t bytes) {
    const std::lock_guard lock(mutex_);
    --shares_;
    asked_ -= bytes;
    trim();
  }

  static void shrink(Mapping& mapping, std::size_t bytes) {
    if (mapping.touched > bytes) madvise(mapping.at + bytes, mapping.touched - bytes, MADV_DONTNEED);
    mapping.touched = std::min(mapping.touched, bytes);
  }

  void lock() { mutex_.lock(); }
  void unlock() { mutex_.unlock(); }

 private:
  void trim() {
    const std::size_t limit = shares_ > 0 ? asked_ : unasked;
    while (held_ > limit) unmap_oldest();
  }

  void unmap_oldest() {
    const Mapping oldest = remove(0);
    munmap(oldest.at, oldest.reserved);
  }

  Mapping remove(std::size_t i) {
    const Mapping removed = kept_[i];
    std::copy(kept_.begin() + i + 1, kept_.begin() + count_, kept_.begin() + i);
    --count_;
    held_ -= removed.touched;
    return removed;
  }

  static constexpr std::size_t mappings_max = 64;
  std::mutex mutex_;
  std::array<Mapping, mappings_max> kept_;
  std::size_t count_ = 0;
  static constexpr std::size_t unasked = std::size_t{256} << 20;
  std::size_t held_ = 0, shares_ = 0, asked_ = 0;
};

Pool& pool();

// The handlers keep the pool unlocked in a forked child, whatever the parent's other threads were doing. So the child
// may still give arrays back.
Pool* make_pool() {
  const int refused = ::pthread_atfork([] { pool().lock(); }, [] { pool().unlock(); }, [] { pool().unlock(); });
  if (refused != 0) throw std::bad_alloc();
  return new Pool;
}

// The pool is never destroyed, because arrays in static objects may outlive any other object.
Pool& pool() {
  static Pool* const the_pool = make_pool();
  return *the_pool;
}

}  // namespace

Mapping map_memory(std::size_t bytes) {
  Mapping mapping;
  if (bytes <= small_bytes) {
    mapping.reserved = (std::max<std::size_t>(bytes, 1) + alignment - 1) / alignment * alignment;
    mapping.at = static_cast<std::byte*>(std::aligned_alloc(alignment, mapping.reserved));
    if (!mapping.at) throw std::bad_alloc();
    return mapping;
  }
  bytes = rounded(bytes);
  if (pool().take(bytes, mapping)) return mapping;
  const std::size_t reserved = with_room(bytes);
  void* at = mmap(nullptr, reserved, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (at == MAP_FAILED) throw std::bad_alloc();
  mapping = {static_cast<std::byte*>(at), reserved, 0};
  return mapping;
}

void grow_mapping(Mapping& mapping, std::size_t bytes) {
  if (is_small(mapping)) {
    const Mapping larger = map_memory(bytes);
    std::memcpy(larger.at, mapping.at, mapping.reserved);
    std::free(mapping.at);
    mapping = larger;
    return;
  }
  if (bytes <= mapping.reserved) return;
  const std::size_t reserved = with_room(rounded(bytes));
  void* at = mremap(mapping.at, mapping.reserved, reserved, MREMAP_MAYMOVE);
  if (at == MAP_FAILED) throw std::bad_alloc();
  mapping.at = static_cast<std::byte*>(at);
  mapping.reserved = reserved;
}

void unmap_memory(Mapping& mapping, std::size_t used) noexcept {
  if (is_small(mapping)) {
    std::free(mapping.at);
  } else {
    mapping.touched = std::min(std::max(mapping.touched, rounded(used)), mapping.reserved);
    pool().give(mapping);
  }
  mapping = {};
}

void shrink_mapping(Mapping& mapping, std::size_t kept, std::size_t used) noexcept {
  if (is_small(mapping)) return;
  const std::size_t from = (kept + page - 1) / page * page;
  const std::size_t to = std::min(std::max(rounded(used), mapping.touched), mapping.reserved);
  if (from < to) madvise(mapping.at + from, to - from, MADV_DONTNEED);
  mapping.touched = std::min(from, mapping.touched);
}

MemoryPoolShare::MemoryPoolShare(std::size_t bytes) : bytes_(bytes) { pool().add_share(bytes); }

MemoryPoolShare::~MemoryPoolShare() { pool().remove_share(bytes_); }

}  // namespace tessera
