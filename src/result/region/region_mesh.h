// Some cells of a triangulation as the arrays of a tile file.
#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

#include "src/geometry/mesh/tile_mesh.h"
#include "src/result/region/judge.h"

namespace tessera {

struct RegionMesh {
  TileMesh mesh;                    // of tile 0, which owns all vertices
  std::vector<std::uint8_t> final;  // by cell of the mesh
};

// The finite cells that meet the region. A function of these cells and their vertices alone: vertices by id, each cell
// with the least first, cells sorted. Neighbours: -1 where the hull of the whole cloud is known to be, else -2 where
// there is no cell. Throws Stopped.
RegionMesh region_mesh(const GrowingTriangulation& triangulation, const CellList& cells, const Judgement& judgement,
                       const std::stop_token& stop);

}  // namespace tessera
