// The cells around a vertex of the plane, or around an edge in space, in their order.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "src/geometry/mesh/tile_mesh.h"

namespace tessera::voronoi {

// The vertices around a vertex, counterclockwise. If the vertex is on the hull, the hull is between the last and the
// first. cells[i] is the triangle of the vertex, around[i] and the next one.
struct OrderedStar {
  std::vector<std::int32_t> around;
  std::vector<std::uint32_t> cells;
  bool on_hull = false;
};

// One cell of a star: the other two vertices, of which `from` comes first counterclockwise.
struct Wedge {
  std::int32_t from = 0, to = 0;
  std::uint32_t cell = 0;
};

class StarOrder {
 public:
  // Sorts the wedges, and puts them in their order around. False when they do not go around once: the tile is damaged.
  bool order(std::span<Wedge> wedges, OrderedStar& star);
  // The same for all triangles with the vertex.
  bool order(const TileMesh& mesh, std::size_t vertex, std::span<const std::uint32_t> cells, OrderedStar& star);

 private:
  std::vector<Wedge> wedges_;
  std::vector<std::int32_t> ends_;
};

}  // namespace tessera::voronoi
