// Final cells: those whose circumsphere lies strictly inside the tile's box. No foreign point can ever enter them, so
// they can be written once and forgotten.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "src/base/big_vector.h"
#include "src/kernel/kernel.h"

namespace tessera {

// The cells of `list` that are not `open`. They have vertices of the tile's own alone.
FinalCells extract_final(const CellList& list, const std::vector<std::uint8_t>& open, int dimension);

// An unordered simplex as a key: its members sorted, padded by 0xffffffff in 2D.
using CellKey = std::array<std::uint32_t, 4>;
CellKey cell_key(const std::uint32_t* vertices, int dimension);

struct CellKeyHash {
  std::size_t operator()(const CellKey& key) const noexcept {
    std::uint64_t h = 0;
    for (const std::uint32_t v : key) h = (h ^ v) * 0x9e3779b97f4a7c15u, h ^= h >> 29;
    return h;
  }
};

}  // namespace tessera
