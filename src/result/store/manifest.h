// How the manifest and the tiles' side files are written down.
#pragma once

#include <filesystem>
#include <string>

#include "src/base/files/temporary.h"
#include "src/base/result.h"
#include "src/result/store/tile_store.h"

namespace tessera::store {

// The side file of a stored tile. Not synced: one that a power cut damaged means that the tile is made again.
Status write_done(const std::filesystem::path& out, NodeId node, const TileEntry& entry);
// The range with one more height; one that is no number, or infinite, changes nothing.
void widen(std::optional<HeightRange>& range, double height);
// Gives a tile's file its name, and the tile a line in the side file.
Status publish_tile(const std::filesystem::path& out, TemporaryFile& temporary, const TileEntry& entry,
                    const StoreOptions& options);
std::string manifest_to_text(const Manifest& manifest);

}  // namespace tessera::store
