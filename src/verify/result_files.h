// Whether the files of a result are those its manifest tells of, before anything in them is believed.
#pragma once

#include <cstdint>
#include <filesystem>

#include "src/base/result.h"
#include "src/store/tile_store.h"

namespace tessera {

// Error corrupt when the file has not this checksum, io when it cannot be read.
Status check_sum(const std::filesystem::path& path, std::uint64_t expected, SumOf what = SumOf::bytes);

// The master file and duplicates.bin have their checksums; the master file is, byte for byte, the one that the manifest
// makes; no tile file and no duplicates.bin is there that the manifest does not know. Error corrupt tells which file.
Status check_files(const std::filesystem::path& out, const Manifest& manifest);

// The tile file is that of its entry: size and checksum, the numbers of vertices and cells, neighbours and attributes
// as the manifest has them. Own vertices lie in the tile's box: error not_delaunay.
Result<TileMesh> open_tile(const std::filesystem::path& out, const TileEntry& entry, const Manifest& manifest);

}  // namespace tessera
