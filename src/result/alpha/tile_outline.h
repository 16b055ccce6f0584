// The outline of a 2D alpha shape in one tile: chains of boundary edges, linked at the tile's own vertices.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "src/base/point.h"
#include "src/result/alpha/tile_alpha.h"

namespace tessera::alpha {

struct OutlineVertex {
  PointId id;
  double x = 0, y = 0;
};

// A boundary edge by the ids of its vertices, with the shape on its left.
using OutlineEdge = std::array<PointId, 2>;

// Own vertices that follow each other on the boundary of one piece of the shape. An edge with vertices of two tiles is
// the last edge of a chain in one tile, and the first edge of a chain in the other one.
struct OutlineChain {
  std::size_t begin = 0, end = 0;  // in TileOutline::vertices
  bool closed = false;
  OutlineEdge first{}, last{};  // the edges to the first vertex and from the last one; of a chain that is not closed
  std::uint32_t piece = 0;
};

// A cell in the shape that other tiles have, too.
struct SharedCell {
  std::array<PointId, 3> ids{};  // ascending
  std::uint32_t piece = 0;
};

struct TileOutline {
  std::vector<OutlineVertex> vertices;
  std::vector<OutlineChain> chains;
  std::vector<SharedCell> shared;
  std::uint32_t pieces = 0;  // the number of pieces that the shape has in the tile
};

// Where several pieces of the shape, or parts of one piece, meet at a vertex, a chain goes on along the same part.
// Nothing when the neighbours of cells contradict each other, as in a damaged file. REQUIRES: a 2D mesh.
std::optional<TileOutline> outline_of(const TileMesh& mesh, const std::vector<std::uint8_t>& in);

}  // namespace tessera::alpha
