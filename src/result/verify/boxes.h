// Checks the partition in the manifest, which says which tile owns which part of space.
#pragma once

#include <filesystem>

#include "src/base/result.h"
#include "src/result/store/tile_store.h"

namespace tessera {

// Checks that the boxes are exactly those of the manifest's partition, that the partition divides space, and that every
// tile in the manifest has a box. Error corrupt names the first tile that is wrong.
Status check_boxes(const Manifest& manifest, const std::filesystem::path& out);

}  // namespace tessera
