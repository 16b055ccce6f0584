// The order of insertion: biased randomised rounds (BRIO) over points that are given in Hilbert order.
// Source: Amenta, Choi, Rote, Incremental constructions con BRIO, SoCG 2003.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "src/base/mixed_bits.h"

namespace tessera {

// Calls insert(i) once for each i in 0..n-1, in rounds. Each round is a random subset, 2^round_bits times as large as
// the round before, and goes through its indices in increasing order. The rounds keep the expected cost low for every
// input. The increasing order keeps each walk short. The order is deterministic.
template <int round_bits = 3, class Insert>
void for_each_in_brio_order(std::size_t n, Insert&& insert) {
  constexpr int rounds = 24 / round_bits;  // with 3 bits: the first round of 10 M points holds about 5
  constexpr std::size_t small = 64;        // so few points need no order
  if (n <= small) {
    for (std::size_t i = 0; i < n; ++i) insert(i);
    return;
  }
  const auto round_of = [](std::uint64_t i) {  // the number of trailing zeros is geometrically distributed
    const int r = std::countr_zero(mixed_bits(i)) / round_bits;
    return r < rounds ? r : rounds - 1;
  };
  std::array<std::vector<std::uint32_t>, rounds> early;  // the rounds before the last; the last round has most points
  for (std::size_t i = 0; i < n; ++i) {
    if (const int r = round_of(i); r > 0) early[r].push_back(static_cast<std::uint32_t>(i));
  }
  for (int r = rounds - 1; r > 0; --r) {
    for (const std::uint32_t i : early[r]) insert(i);
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (round_of(i) == 0) insert(i);
  }
}

}  // namespace tessera
