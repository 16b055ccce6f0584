// The cells of the flat kernel in 2D, which are triangles: 32 bytes each, two to a cache line.
#pragma once

#include "src/geometry/kernel/flat/cells.h"

namespace tessera::flat2 {

using flat::frozen_bit;
using flat::Index;
using flat::Located;

inline constexpr Index vertices_max = flat::cells_max / 2;

inline constexpr Index next_of[3] = {1, 2, 0}, before[3] = {2, 0, 1};

enum class State : Index { plain, open, final, dead };  // open, final: marks of one call; dead: a free slot

// A triangle, counterclockwise. Facet i is the edge from v[i + 1] to v[i + 2]. v[0] is never infinite.
struct alignas(32) Cell {
  static constexpr int dimension = 2;
  static constexpr Index corners = 3;
  static constexpr std::uint8_t facet_of[3][2] = {{1, 2}, {2, 0}, {0, 1}};

  Vertex v[3];
  State state;
  Index n[3];

  bool infinite() const { return v[1] == infinite_vertex || v[2] == infinite_vertex; }
  void set(const Vertex* vertices) {
    for (Index i = 0; i < corners; ++i) v[i] = vertices[i];
    state = State::plain;
  }
  void free() { state = State::dead; }
  bool dead() const { return state == State::dead; }
  void mark(bool is_open) { state = is_open ? State::open : State::final; }
  bool marked() const { return state == State::open || state == State::final; }
  bool open() const { return state == State::open; }
  void unmark() { state = State::plain; }
  Vertex vertex(Index i) const { return v[i]; }
};
static_assert(sizeof(Cell) == 32);

}  // namespace tessera::flat2
