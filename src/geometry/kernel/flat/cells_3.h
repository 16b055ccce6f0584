// The cells of the flat kernel in 3D: 32 bytes each, two to a cache line.
#pragma once

#include "src/geometry/kernel/flat/cells.h"

namespace tessera::flat3 {

using flat::frozen_bit;
using flat::Index;
using flat::Located;

// The top two bits of v[0] mark a cell while one call runs. Between calls v[0] is a plain vertex number.
inline constexpr Index mark_shift = 30;
inline constexpr Index vertex_mask = (Index{1} << mark_shift) - 1;
inline constexpr Index mark_in = Index{1} << mark_shift;   // in the conflict zone, or open
inline constexpr Index mark_out = Index{2} << mark_shift;  // asked; not in the conflict zone, or not open
inline constexpr Index vertices_max = vertex_mask - 1;
inline constexpr Index dead_vertex = vertex_mask;  // v[0] of a slot without a cell

// A tetrahedron. The infinite vertex is always v[3]; the permutations of facet_of keep it last.
struct alignas(32) Cell {
  static constexpr int dimension = 3;
  static constexpr Index corners = 4;
  static constexpr std::uint8_t facet_of[4][3] = {{1, 2, 3}, {2, 0, 3}, {0, 1, 3}, {2, 1, 0}};

  Index v[4];
  Index n[4];

  bool infinite() const { return v[3] == infinite_vertex; }
  void set(const Vertex* vertices) {
    for (Index i = 0; i < corners; ++i) v[i] = vertices[i];
  }
  void free() { v[0] = dead_vertex; }
  bool dead() const { return v[0] == dead_vertex; }
  void mark(bool is_open) { v[0] |= is_open ? mark_in : mark_out; }
  bool marked() const { return v[0] > vertex_mask; }
  bool open() const { return (v[0] & ~vertex_mask) == mark_in; }
  void unmark() { v[0] &= vertex_mask; }
  Vertex vertex(Index i) const { return v[i] & vertex_mask; }
};
static_assert(sizeof(Cell) == 32);

// The cell that the neighbour word `facet` names. Masking the word saves shifting it down and up again.
inline Cell& cell_at(Cell* cells, Index facet) {
  return *reinterpret_cast<Cell*>(reinterpret_cast<std::byte*>(cells) + std::size_t{facet & ~Index{3}} * 8);
}
inline const Cell& cell_at(const Cell* cells, Index facet) { return cell_at(const_cast<Cell*>(cells), facet); }

}  // namespace tessera::flat3
