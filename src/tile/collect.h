// From a kernel's cells to the canonical arrays of a tile file.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "src/base/point.h"
#include "src/kernel/kernel.h"
#include "src/tile/final_cells.h"
#include "src/tile/tile_mesh.h"

namespace tessera {

struct CollectInput {
  enum : std::uint8_t { other = 0, kept = 1, fill = 2 };
  struct VertexInfo {
    Point at;  // of foreign vertices
    std::uint64_t id = 0;
    std::uint32_t owner = 0;
    std::uint32_t rank = 0;  // of local vertices
  };

  int dimension;
  TileId self;
  std::span<const Point> points;         // the tile's own, by rank
  std::span<const std::uint64_t> ids;    // by rank
  CellList cells;                        // of the kernel
  std::vector<std::uint8_t> held;        // by cell: what it is to this tile
  std::vector<VertexInfo> vertices;      // by vertex
  FinalCells final_cells;                // handed out earlier: they border the fill
};

// Frees each list as soon as it has been used: this is where a tile needs most memory.
TileMesh make_mesh(CollectInput input);

}  // namespace tessera
