// Whether the files of a result are those its manifest tells of, before anything in them is believed.
#pragma once

#include <cstddef>

#include "src/base/result.h"
#include "src/result/tile_source.h"

namespace tessera {

// The master file and duplicates.bin have their checksums; the master file is, byte for byte, the one that the manifest
// makes, or for a moment of a change that of the version before; no tile file and no duplicates.bin is there that no
// version knows. Error corrupt tells which file.
Status check_files(const TileSource& source);

// The `i`-th tile, whose file has its checksum, and of which all is as the manifest says. Own vertices lie in the
// tile's box: error not_delaunay.
Result<TileMesh> open_tile(const TileSource& source, std::size_t i);

}  // namespace tessera
