// The one way from a tile file to arrays. Only src/result includes this: others read tiles through its TileSource,
// which knows which file a tile has, and compares what is in the file with the manifest.
#pragma once

#include <filesystem>
#include <vector>

#include "src/base/result.h"
#include "src/result/store/tile_store.h"

namespace tessera {

// What is read of a tile beside its vertices.
struct TileParts {
  bool cells = true;
  bool rows = false;  // the attributes of the vertices
  bool cell_columns = false;
};

namespace store {

// Reads a tile file back, of this format or an older one. Every array is checked (lengths, checksums, ranges, flags);
// corrupt names the file and the place. Without cells: cells, cell_ghost and neighbors are empty.
Result<StoredTile> read_tile(const std::filesystem::path& file, TileId tile, const TileParts& parts);
// Only the source indices of the tile's own vertices, in the file's order.
Result<std::vector<PointId>> read_own_ids(const std::filesystem::path& file, TileId tile);

}  // namespace store
}  // namespace tessera
