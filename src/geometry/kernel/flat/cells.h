// What the cells of the flat kernels have in common. A Cell of dimension d has d + 1 `corners`. v[i] are its vertices,
// positively oriented. n[i] is the neighbour across the facet opposite v[i]. Its other members:
//   facet_of[i]     all corners but i, ordered so that (p, v[facet_of[i][0]], ...) has the orientation of the cell
//                   with p in place of v[i]
//   set(vertices)   makes the slot an unmarked cell with these vertices; does not set neighbours
//   free(), dead()  makes the slot free; whether the slot is free
//   mark(open), marked(), open(), unmark()   the mark, which lasts for one call of the kernel
//   vertex(i)       v[i], also while a call marks cells
#pragma once

#include <cstddef>
#include <cstdint>

#include "src/geometry/kernel/kernel.h"

namespace tessera::flat {

using Index = std::uint32_t;

// An Index that names a neighbour is 4 * cell + facet in both dimensions: the slot of the neighbour, and the facet
// through which the neighbour sees this cell. So the way back needs no search. With `frozen_bit` the neighbour is a
// cell that freeze() has handed out: see CellList.
inline constexpr Index frozen_bit = across_frozen;
inline constexpr Index cells_max = Index{1} << 29;

// The answer of a point location.
struct Located {
  Index cell = 0;   // a cell in conflict with the point, or a cell with the vertex `same`
  Vertex same = 0;  // the vertex with the coordinates of the point, or 0
};

// Returns the facet of `to` that is facet i of `from` seen from the other side, or `corners` if the cells have no such
// facet.
template <class Cell>
Index common_facet(const Cell& from, Index i, const Cell& to) {
  // place[k] is the corner of `from` at which corner k of `to` is found. The one corner of `to` that `from` lacks takes
  // place i. Two cells that share the facet from opposite sides give an odd permutation. If a second corner is missing,
  // two places are equal and the product is 0.
  int place[Cell::corners], parity = 1;
  Index facet = Cell::corners;
  for (Index k = 0; k < Cell::corners; ++k) {
    Index at = i;
    for (Index j = 0; j < Cell::corners; ++j) at = j != i && from.v[j] == to.v[k] ? j : at;
    facet = at == i ? k : facet;
    place[k] = static_cast<int>(at);
    for (Index j = 0; j < k; ++j) parity *= place[k] - place[j];
  }
  return parity < 0 ? facet : Cell::corners;
}

// Moves the infinite vertex to the end, by an even permutation. Returns false if the cell has the infinite vertex
// twice.
template <class Cell>
bool put_infinite_last(Cell& cell) {
  constexpr Index last = Cell::corners - 1;
  Index i = last;
  int times = 0;
  for (Index k = 0; k <= last; ++k) {
    if (cell.v[k] == infinite_vertex) i = k, ++times;
  }
  if (times > 1 || i == last) return times <= 1;
  const Index other = i == 0 ? 1 : 0;
  for (Index* indices : {cell.v, cell.n}) {
    const Index moved = indices[i];
    indices[i] = indices[other];
    indices[other] = indices[last];
    indices[last] = moved;
  }
  return true;
}

}  // namespace tessera::flat
