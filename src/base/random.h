// Random numbers that are the same on every machine and with every library. So users can quote the number that a
// generator began with.
#pragma once

#include <bit>
#include <cstdint>

#include "src/base/mixed_bits.h"

namespace tessera {

// A generator of random numbers: xoshiro256++, seeded by splitmix64 as its authors advise. Source: Blackman, Vigna, ACM
// TOMS 2021.
class Random {
 public:
  explicit Random(std::uint64_t seed) {
    for (auto& word : state_) word = mixed_bits(seed += 0x9E3779B97F4A7C15u);
  }
  std::uint64_t bits() {
    const std::uint64_t result = std::rotl(state_[0] + state_[3], 23) + state_[0];
    const std::uint64_t shifted = state_[1] << 17;
    state_[2] ^= state_[0];
    state_[3] ^= state_[1];
    state_[1] ^= state_[2];
    state_[0] ^= state_[3];
    state_[2] ^= shifted;
    state_[3] = std::rotl(state_[3], 45);
    return result;
  }
  // Returns a multiple of 2^-53 in [0, 1).
  double unit() { return static_cast<double>(bits() >> 11) * 0x1p-53; }
  double between(double low, double high) { return low + (high - low) * unit(); }

 private:
  std::uint64_t state_[4];
};

}  // namespace tessera
