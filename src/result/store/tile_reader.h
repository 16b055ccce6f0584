// Reads tile files. Only src/result includes this header: other code reads tiles through TileSource, which knows the
// file of each tile and compares the contents with the manifest.
#pragma once

#include <filesystem>
#include <vector>

#include "src/base/result.h"
#include "src/result/store/data_file.h"
#include "src/result/store/tile_store.h"

namespace tessera {

// Selects what is read of a tile in addition to its vertices.
struct TileFields {
  bool cells = true;
  bool rows = false;  // the attributes of the vertices
  bool cell_columns = false;
};

namespace store {

// Reads a tile file of this format or an older one. Every array is checked (lengths, checksums, ranges, flags). Error
// corrupt has the file and the array. Without cells, the arrays cells, cell_ghost and neighbors are empty.
Result<StoredTile> read_tile(DataFile file, TileId tile, const TileFields& fields);
// Reads only the source indices of the tile's own vertices, in the file's order.
Result<std::vector<PointId>> read_own_ids(DataFile file, TileId tile);
// read_tile() of a file on a disk.
Result<StoredTile> read_tile(const std::filesystem::path& path, TileId tile, const TileFields& fields);

}  // namespace store
}  // namespace tessera
