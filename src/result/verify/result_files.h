// Checks that the files of a result are those of its manifest, before anything in them is used.
#pragma once

#include <cstddef>

#include "src/base/result.h"
#include "src/result/tile_source.h"

namespace tessera {

// Checks that the master file and the list of duplicates have their checksums; that the master file is, byte for byte,
// what the manifest determines, or the master file of the version before, which may remain after an interrupted change;
// and that no tile file exists that no version knows. Of an older version, the master file is not checked, because it
// belongs to the newest one. Error corrupt names the file.
Status check_files(const TileSource& source);

// Reads the `i`-th tile, and checks its checksum and everything that the manifest says of it. Error not_delaunay when
// an own vertex lies outside the tile's box.
Result<TileMesh> open_tile(const TileSource& source, std::size_t i);

}  // namespace tessera
