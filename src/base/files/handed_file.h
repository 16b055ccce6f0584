// Of a run folder: handed/000042.bin, a tile as a node had it that has left the cluster, for whichever begins it next.
// A frame of kind state (frame.h).
#pragma once

#include <filesystem>

#include "src/base/ids.h"

namespace tessera {

std::filesystem::path handed_file(const std::filesystem::path& run, TileId tile);

}  // namespace tessera
