// How the manifest and the tiles' side files are written down.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/store/tile_store.h"

namespace tessera::store {

inline constexpr int format_version = 1;

std::filesystem::path done_file(const std::filesystem::path& out, TileId tile);
std::filesystem::path manifest_file(const std::filesystem::path& out);
std::filesystem::path master_file(const std::filesystem::path& out);
std::filesystem::path duplicates_file(const std::filesystem::path& out);

// The side file of a stored tile. Not synced: one that a power cut damaged means that the tile is made again.
Status write_done(const std::filesystem::path& out, const TileEntry& entry);
std::string manifest_to_text(const Manifest& manifest);

// The bytes of the master file, to stand beside tiles/. `path` is for messages.
Result<std::vector<std::byte>> make_master(const std::filesystem::path& path, const Manifest& manifest);

}  // namespace tessera::store
