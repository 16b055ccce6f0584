// Memory that runs out when it is told to: operator new in all its forms, the anonymous mappings of the memory pool,
// and aligned_alloc(), which the store takes its buffers from. Linked into a program, it replaces them all.
#pragma once

#include <cstdint>

namespace tessera::testing {

// What happened between fail() and recover(), on all threads that were not exempt.
struct Allocations {
  std::uint64_t asked = 0, failed = 0;
};

// From now on the `first`-th allocation (from 1) and those after it, `count` in all, fail; with `count` 0 none.
void fail(std::uint64_t first, std::uint64_t count);
Allocations so_far();
// None fails any more.
Allocations recover();

// What this thread allocates neither counts nor fails, until it is set otherwise. Returns what was set before.
bool set_exempt(bool exempt);

}  // namespace tessera::testing
