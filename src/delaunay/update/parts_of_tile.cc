#include "src/delaunay/update/parts_of_tile.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <span>

namespace tessera {

std::map<TileId, PartOfTile> parts_of(const TileMesh& mesh) {
  std::map<TileId, PartOfTile> parts;
  for (std::size_t v = 0; v < mesh.owners.size(); ++v) {
    if (mesh.point_ghost[v] == 0) parts[mesh.owners[v]].own.push_back(static_cast<std::int32_t>(v));
  }
  const auto corners = static_cast<std::size_t>(mesh.dimension) + 1;
  for (std::size_t at = 0; at < mesh.cells.size(); at += corners) {
    const std::span cell(&mesh.cells[at], corners);
    const TileId first = mesh.owners[cell[0]];
    if (std::all_of(cell.begin(), cell.end(), [&](std::int32_t v) { return mesh.owners[v] == first; })) continue;
    for (const std::int32_t own : cell) {
      if (mesh.point_ghost[own] != 0) continue;
      const TileId tile = mesh.owners[own];
      auto& foreign = parts[tile].foreign;
      std::copy_if(cell.begin(), cell.end(), std::back_inserter(foreign),
                   [&](std::int32_t v) { return mesh.owners[v] != tile; });
    }
  }
  for (auto& [tile, part] : parts) {
    std::sort(part.foreign.begin(), part.foreign.end());
    part.foreign.erase(std::unique(part.foreign.begin(), part.foreign.end()), part.foreign.end());
  }
  return parts;
}

}  // namespace tessera
