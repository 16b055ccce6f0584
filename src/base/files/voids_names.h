// Names of what the search for voids writes to its scratch folder (src/result/voids/watershed.h), one file a tile.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "src/base/ids.h"

namespace tessera {

inline std::filesystem::path voids_flow_file(const std::filesystem::path& scratch, TileId tile) {
  return scratch / ("flow-" + std::to_string(tile.value) + ".bin");
}
// What other tiles ask this tile, and what they answer.
inline std::filesystem::path voids_asked_file(const std::filesystem::path& scratch, TileId tile) {
  return scratch / ("asked-" + std::to_string(tile.value) + ".bin");
}
inline std::filesystem::path voids_answers_file(const std::filesystem::path& scratch, TileId tile) {
  return scratch / ("answers-" + std::to_string(tile.value) + ".bin");
}
// The zones of some millions of points, by source index; `number` counts these files.
inline std::filesystem::path voids_zones_file(const std::filesystem::path& scratch, std::uint64_t number) {
  return scratch / ("zones-" + std::to_string(number) + ".bin");
}

}  // namespace tessera
