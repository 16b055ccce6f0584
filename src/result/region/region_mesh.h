// Converts some cells of a triangulation to the arrays of a tile file.
#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

#include "src/geometry/mesh/tile_mesh.h"
#include "src/result/region/judge.h"

namespace tessera {

struct RegionMesh {
  TileMesh mesh;                    // of tile 0, which owns all vertices
  std::vector<std::uint8_t> final;  // by cell of the mesh: 1 if the cell is final
};

// Returns the finite cells that meet the region. The result depends only on these cells and their vertices: vertices
// are sorted by id, each cell begins with its least vertex, and cells are sorted. A missing neighbour is -1 where the
// hull of the whole cloud is known to be, and -2 elsewhere. Throws Stopped.
RegionMesh region_mesh(const GrowingTriangulation& triangulation, const CellList& cells, const Judgement& judgement,
                       const std::stop_token& stop);

}  // namespace tessera
