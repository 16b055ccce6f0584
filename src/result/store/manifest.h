// Writes the manifest, and the side files that list the stored tiles.
#pragma once

#include <filesystem>
#include <string>

#include "src/base/files/temporary.h"
#include "src/base/result.h"
#include "src/result/store/tile_store.h"

namespace tessera::store {

// Adds a stored tile to the side file of the node. The file is not synced: if a power cut damages a line, the tile is
// made again.
Status write_done(const std::filesystem::path& out, NodeId node, const TileEntry& entry);
// Extends the range to include `height`. Ignores heights that are not finite.
void widen(std::optional<HeightRange>& range, double height);
// Renames a tile's file to its final name, and adds the tile to the side file.
Status publish_tile(const std::filesystem::path& out, TemporaryFile& temporary, const TileEntry& entry,
                    const StoreOptions& options);
std::string manifest_to_text(const Manifest& manifest);

}  // namespace tessera::store
