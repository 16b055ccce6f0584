// Sorting that ends soon when it is asked to, however many elements there are.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <stop_token>

#include "src/base/stopped.h"

namespace tessera {

// std::sort(). Throws Stopped: then the elements are all there, in any order. REQUIRES: elements are copied without
// exceptions.
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
