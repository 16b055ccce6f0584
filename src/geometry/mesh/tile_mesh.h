// The cells that a tile gives to the store: every cell with at least one local vertex, as flat arrays.
#pragma once

#include <cstdint>
#include <vector>

#include "src/base/big_vector.h"
#include "src/base/point.h"

namespace tessera {

// The mesh is canonical: it depends on the global triangulation and the tile's points alone, so two runs give equal
// bytes. Local vertices come first, in Hilbert order, then foreign vertices by id (images of one point by code). Cells
// are sorted. Each cell is positively oriented and begins with its least vertex. A neighbour of -1 is the outside of
// the hull. -2 is a cell that only other tiles hold, or possibly the outside when no vertex of the facet is local.
struct TileMesh {
  int dimension = 3;
  std::vector<Point> points;              // n vertices
  std::vector<PointId> ids;               // n source indices
  std::vector<TileId> owners;             // n tiles: the owner of each vertex
  std::vector<std::uint8_t> point_ghost;  // n flags: 1 = foreign
  // n codes (src/base/image.h): how many periods a vertex lies away from the point `ids`; empty: none lies away. A
  // tile's own points can be foreign vertices then.
  std::vector<std::uint8_t> offsets;
  BigVector<std::int32_t> cells;       // m x (d+1) indices into points
  BigVector<std::uint8_t> cell_ghost;  // m flags: 1 = not main in this tile
  BigVector<std::uint8_t> cell_final;  // m flags: 1 = surely a cell of the whole triangulation; empty: all cells are
  BigVector<std::int32_t> neighbors;   // m x (d+1): the cell opposite each vertex; -1: none; -2: not known here

  std::size_t bytes() const {
    return points.size() * (sizeof(Point) + 13) + cell_ghost.size() + cell_final.size() +
           (cells.size() + neighbors.size()) * 4;
  }
};

}  // namespace tessera
