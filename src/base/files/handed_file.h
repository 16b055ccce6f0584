// The name handed/000042.bin in a run folder: the image of a tile that was left by a node which has left the cluster,
// for the node that begins the tile next. The file is a frame of kind state (frame.h).
#pragma once

#include <filesystem>

#include "src/base/ids.h"

namespace tessera {

std::filesystem::path handed_file(const std::filesystem::path& run, TileId tile);

}  // namespace tessera
