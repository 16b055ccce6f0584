// Sorting that can be stopped soon, however many elements there are.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <stop_token>

#include "src/base/stopped.h"

namespace tessera {

// Sorts like std::sort(). Throws Stopped when stopped; then all elements are still there, in any order. REQUIRES:
// copying an element throws no exception.
template <class Iterator, class Less = std::less<>>
void sort_unless_stopped(Iterator begin, Iterator end, const std::stop_token& stop, Less less = {}) {
  constexpr std::uint32_t comparisons_a_look = 1 << 16;
  StopCheck check(stop, comparisons_a_look);
  std::sort(begin, end, [&](const auto& a, const auto& b) {
    check.step();
    return less(a, b);
  });
}

}  // namespace tessera
