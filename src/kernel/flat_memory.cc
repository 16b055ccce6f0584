#include "src/kernel/flat_memory.h"

#include <sys/mman.h>

#include <algorithm>
#include <array>
#include <new>
#include <utility>

namespace tessera::flat {
namespace {

constexpr std::size_t page = 4096, huge_page = std::size_t{2} << 20;
constexpr std::size_t huge_from = 4 * huge_page;  // smaller arrays would waste much of a huge page

std::size_t rounded(std::size_t bytes) {
  const std::size_t unit = bytes >= huge_from ? huge_page : page;
  return (bytes + unit - 1) / unit * unit;
}

void advise(const Mapping& mapping) {
  // Only advice: where the system has no huge pages everything works as well, if slower.
  if (mapping.pages == Pages::huge && mapping.reserved >= huge_from)
    madvise(mapping.at, mapping.reserved, MADV_HUGEPAGE);
}

void release(const Mapping& mapping) noexcept { munmap(mapping.at, mapping.reserved); }

// What this thread has given back. At most a few mappings, and at most so many touched bytes in each: a tile's arrays.
class Pool {
 public:
  ~Pool() {
    for (const Mapping& m : kept_) {
      if (m.at) release(m);
    }
  }
  bool take(std::size_t bytes, Pages pages, Mapping& out) {
    Mapping* best = nullptr;
    for (Mapping& m : kept_) {
      // Not one far too large: a small kernel would hold the pages of a large one.
      if (!m.at || m.pages != pages || m.reserved < bytes || m.reserved / 4 > bytes) continue;
      if (!best || m.reserved < best->reserved) best = &m;
    }
    if (!best) return false;
    out = std::exchange(*best, {});
    return true;
  }
  void give(const Mapping& mapping, std::size_t used) noexcept {
    if (used > bytes_each) {
      release(mapping);
      return;
    }
    Mapping* victim = &kept_[next_++ % kept_.size()];
    for (Mapping& m : kept_) {
      if (!m.at) victim = &m;
    }
    if (victim->at) release(*victim);
    *victim = mapping;
  }

 private:
  static constexpr std::size_t bytes_each = std::size_t{256} << 20;
  std::array<Mapping, 8> kept_{};
  std::size_t next_ = 0;
};

thread_local Pool pool;

}  // namespace

Mapping map_memory(std::size_t bytes, Pages pages) {
  Mapping mapping;
  bytes = rounded(std::max(bytes, page));
  if (pool.take(bytes, pages, mapping)) return mapping;
  void* at = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (at == MAP_FAILED) throw std::bad_alloc();
  mapping = {static_cast<std::byte*>(at), bytes, pages};
  advise(mapping);
  return mapping;
}

void grow_mapping(Mapping& mapping, std::size_t bytes) {
  bytes = rounded(bytes);
  void* at = mremap(mapping.at, mapping.reserved, bytes, MREMAP_MAYMOVE);
  if (at == MAP_FAILED) throw std::bad_alloc();
  mapping = {static_cast<std::byte*>(at), bytes, mapping.pages};
  advise(mapping);
}

void unmap_memory(Mapping& mapping, std::size_t used) noexcept {
  if (mapping.at) pool.give(mapping, used);
  mapping = {};
}

void shrink_mapping(const Mapping& mapping, std::size_t kept, std::size_t used) noexcept {
  const std::size_t from = (kept + page - 1) / page * page, to = std::min(rounded(used), mapping.reserved);
  if (from < to) madvise(mapping.at + from, to - from, MADV_DONTNEED);
}

void release_pages(const Mapping& mapping, std::size_t bytes) noexcept {
  const std::size_t whole = std::min(bytes, mapping.reserved) / huge_page * huge_page;
  if (whole > 0) madvise(mapping.at, whole, MADV_DONTNEED);
}

}  // namespace tessera::flat
