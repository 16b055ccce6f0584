// A hash for keys that differ only in a few high or low bits, for tables whose sizes are powers of two.
#pragma once

#include <cstddef>
#include <cstdint>

#include "src/base/ids.h"
#include "src/base/mixed_bits.h"

namespace tessera {

struct MixHash {
  std::size_t operator()(std::uint64_t x) const noexcept { return finalised_bits(x); }
  template <class Tag, class Rep>
  std::size_t operator()(const Id<Tag, Rep>& id) const noexcept {
    return operator()(std::uint64_t{id.value});
  }
};

}  // namespace tessera
