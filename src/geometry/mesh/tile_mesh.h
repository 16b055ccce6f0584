// What one tile gives to the store: every cell with a vertex of its own, as flat arrays.
#pragma once

#include <cstdint>
#include <vector>

#include "src/base/big_vector.h"
#include "src/base/point.h"

namespace tessera {

// Canonical: a function of the global triangulation and the tile's points alone, so that two runs give equal bytes.
// Vertices: the tile's own, in Hilbert order, then foreign ones by id. Cells: positively oriented, the least vertex
// first, sorted.
struct TileMesh {
  int dimension = 3;
  std::vector<Point> points;              // n
  std::vector<PointId> ids;               // n source indices
  std::vector<TileId> owners;             // n: the tile that owns each vertex
  std::vector<std::uint8_t> point_ghost;  // n: 1 = foreign
  BigVector<std::int32_t> cells;          // m x (d+1) indices into points
  BigVector<std::uint8_t> cell_ghost;     // m: 1 = not main here
  BigVector<std::uint8_t> cell_final;     // m: 1 = for sure a cell of the whole triangulation; or empty: all are
  BigVector<std::int32_t> neighbors;      // m x (d+1): across the facet opposite each vertex; -1 outside, -2 elsewhere

  std::size_t bytes() const {
    return points.size() * (sizeof(Point) + 13) + cell_ghost.size() + cell_final.size() +
           (cells.size() + neighbors.size()) * 4;
  }
};

}  // namespace tessera
