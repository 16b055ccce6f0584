// A hash for keys that differ only in a few high or low bits, for tables whose sizes are powers of two. It is the
// finaliser of splitmix64 (Steele, Lea, Flood, OOPSLA 2014).
#pragma once

#include <cstddef>
#include <cstdint>

#include "src/base/ids.h"

namespace tessera {

struct MixHash {
  std::size_t operator()(std::uint64_t x) const noexcept {
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
  }
  template <class Tag, class Rep>
  std::size_t operator()(const Id<Tag, Rep>& id) const noexcept {
    return operator()(std::uint64_t{id.value});
  }
};

}  // namespace tessera
