// What a pass over a result puts down in its scratch folder (src/result/pass.h).
#pragma once

#include <filesystem>

#include "src/base/ids.h"

namespace tessera {

// Of a tile: its values, and what others have sent it.
std::filesystem::path pass_values_file(const std::filesystem::path& scratch, TileId tile);
std::filesystem::path pass_sent_file(const std::filesystem::path& scratch, TileId tile);

}  // namespace tessera
