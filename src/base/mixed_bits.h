// The mixing of splitmix64: bijections in which every input bit affects all output bits. Source: Steele, Lea, Flood,
// OOPSLA 2014.
#pragma once

#include <cstdint>

namespace tessera {

// The finaliser alone, which keeps 0.
constexpr std::uint64_t finalised_bits(std::uint64_t v) {
  v = (v ^ (v >> 30)) * 0xbf58476d1ce4e5b9u;
  v = (v ^ (v >> 27)) * 0x94d049bb133111ebu;
  return v ^ (v >> 31);
}

// A whole step of the generator.
constexpr std::uint64_t mixed_bits(std::uint64_t v) { return finalised_bits(v + 0x9e3779b97f4a7c15u); }

}  // namespace tessera
