// The partition in the manifest: which tile owns which part of space.
#pragma once

#include <filesystem>

#include "src/base/result.h"
#include "src/result/store/tile_store.h"

namespace tessera {

// Whether the boxes are exactly those of the manifest's partition, which part space; every tile in the manifest has
// one. Error corrupt names the first tile that does not fit.
Status check_boxes(const Manifest& manifest, const std::filesystem::path& out);

}  // namespace tessera
