// The cells of the flat kernel in 3D: 32 bytes each, two to a cache line.
#pragma once

#include <cstddef>
#include <cstdint>

#include "src/kernel/kernel.h"

namespace tessera::flat {

using Word = std::uint32_t;

// A cell and one of its facets, 4 * cell + facet: a neighbour names the facet it is seen through, so the way back needs
// no search. With `frozen_bit` the cell is one that freeze() has handed out, by its number there.
inline constexpr Word frozen_bit = Word{1} << 31;
inline constexpr Word cells_max = Word{1} << 29;
// The two top bits of v[0] mark a cell while one call runs; all others see plain vertex numbers.
inline constexpr Word mark_shift = 30;
inline constexpr Word vertex_mask = (Word{1} << mark_shift) - 1;
inline constexpr Word mark_in = Word{1} << mark_shift;   // in the conflict zone
inline constexpr Word mark_out = Word{2} << mark_shift;  // asked, and not in it
inline constexpr Word vertices_max = vertex_mask - 1;
inline constexpr Word dead_vertex = vertex_mask;  // v[0] of a slot without a cell

// Positively oriented. n[i] is across the facet opposite v[i]. The infinite vertex is always v[3].
struct alignas(32) Cell {
  Word v[4];
  Word n[4];
  bool infinite() const { return v[3] == infinite_vertex; }
  bool dead() const { return v[0] == dead_vertex; }
};
static_assert(sizeof(Cell) == 32);

// The cell a neighbour word names, with its facet: spares shifting down and up again.
inline Cell& cell_at(Cell* cells, Word facet) {
  return *reinterpret_cast<Cell*>(reinterpret_cast<std::byte*>(cells) + std::size_t{facet & ~Word{3}} * 8);
}
inline const Cell& cell_at(const Cell* cells, Word facet) { return cell_at(const_cast<Cell*>(cells), facet); }

// (p, v[facet_of[i][0]], v[facet_of[i][1]], v[facet_of[i][2]]) has the orientation of the cell with p in place of v[i].
// v[3], where the infinite vertex is, stays last.
inline constexpr std::uint8_t facet_of[4][3] = {{1, 2, 3}, {2, 0, 3}, {0, 1, 3}, {2, 1, 0}};

}  // namespace tessera::flat
