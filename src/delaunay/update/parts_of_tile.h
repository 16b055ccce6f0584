// What each part of a tile that is split needs of it: its own points, and the vertices with which they share a cell.
// With these the star of each own point is what it is in the whole tile (docs/updates-design.md).
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "src/base/ids.h"
#include "src/geometry/mesh/tile_mesh.h"

namespace tessera {

// Vertices of the whole tile, as indices, ascending.
struct PartOfTile {
  std::vector<std::int32_t> own, foreign;
};

// By the number of the part. `mesh`: the whole tile; its point_ghost are as before the split, and its owners are those
// afterwards.
std::map<TileId, PartOfTile> parts_of(const TileMesh& mesh);

}  // namespace tessera
