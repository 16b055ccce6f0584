// Reads tile files of format 1: VTKHDF, one HDF5 file a tile. The only user of HDF5.
#pragma once

#include <filesystem>

#include "src/base/result.h"
#include "src/store/tile_store.h"

namespace tessera::store {

// As read_tile() and read_tile_vertices(). mesh.owners is left empty: the file does not say.
Result<StoredTile> read_format1_tile(const std::filesystem::path& path, bool with_cells, bool with_rows);

}  // namespace tessera::store
