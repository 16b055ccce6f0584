// Names of what a pass over a result writes to its scratch folder (src/result/pass.h).
#pragma once

#include <filesystem>

#include "src/base/ids.h"

namespace tessera {

// The values of a tile, and what other tiles have sent to it.
std::filesystem::path pass_values_file(const std::filesystem::path& scratch, TileId tile);
std::filesystem::path pass_sent_file(const std::filesystem::path& scratch, TileId tile);

}  // namespace tessera
