// What the cells of the flat kernels have in common. A Cell of dimension d has d + 1 `corners`: v[i] are its vertices,
// positively oriented, and n[i] is across the facet opposite v[i]. Its other members:
//   facet_of[i]     the corners but i, so that (p, v[facet_of[i][0]], ...) has the orientation of the cell with p in
//                   place of v[i]
//   set(vertices)   makes a slot a cell that is not marked; its neighbours are not set
//   free(), dead()  makes a slot one without a cell; whether it is
//   mark(open), marked(), open(), unmark()   the mark of one call
//   vertex(i)       v[i], also while a call marks cells
#pragma once

#include <cstddef>
#include <cstdint>

#include "src/geometry/kernel/kernel.h"

namespace tessera::flat {

using Word = std::uint32_t;

// A cell and one of its facets, 4 * cell + facet in both dimensions: a neighbour names the facet it is seen through, so
// the way back needs no search. With `frozen_bit` the cell is one that freeze() has handed out: see CellList.
inline constexpr Word frozen_bit = across_frozen;
inline constexpr Word cells_max = Word{1} << 29;

struct Located {
  Word cell = 0;    // in conflict with the point
  Vertex same = 0;  // the vertex with equal coordinates, or 0
};

// The facet of `to` that is facet i of `from` seen from the other side; `corners` if there is none.
template <class Cell>
Word common_facet(const Cell& from, Word i, const Cell& to) {
  // Where the corners of `to` are in `from`; one of them, instead of corner i, is nowhere. From the other side that is
  // an odd permutation. The product is 0 for what is none.
  int place[Cell::corners], parity = 1;
  Word facet = Cell::corners;
  for (Word k = 0; k < Cell::corners; ++k) {
    Word at = i;
    for (Word j = 0; j < Cell::corners; ++j) at = j != i && from.v[j] == to.v[k] ? j : at;
    facet = at == i ? k : facet;
    place[k] = static_cast<int>(at);
    for (Word j = 0; j < k; ++j) parity *= place[k] - place[j];
  }
  return parity < 0 ? facet : Cell::corners;
}

// Moves the infinite vertex to the end, by an even permutation. False if it is there twice.
template <class Cell>
bool put_infinite_last(Cell& cell) {
  constexpr Word last = Cell::corners - 1;
  Word i = last;
  int times = 0;
  for (Word k = 0; k <= last; ++k) {
    if (cell.v[k] == infinite_vertex) i = k, ++times;
  }
  if (times > 1 || i == last) return times <= 1;
  const Word other = i == 0 ? 1 : 0;
  for (Word* words : {cell.v, cell.n}) {
    const Word moved = words[i];
    words[i] = words[other];
    words[other] = words[last];
    words[last] = moved;
  }
  return true;
}

}  // namespace tessera::flat
