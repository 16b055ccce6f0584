// The partition in the manifest: which tile owns which part of space.
#pragma once

#include <filesystem>

#include "src/base/result.h"
#include "src/store/tile_store.h"

namespace tessera {

// Whether the boxes are exactly those of the manifest's partition, which part space; every tile in the manifest has
// one. Format 1 tells no more than the boxes. They must be disjoint and cover space, as those of a tree of planes do: a
// set of more than one box is parted by a plane that cuts none of them, and each part again, down to single boxes, each
// of which must be what the planes left. With the partition "random", where no box says anything, each must be all of
// space. Error corrupt names the first tile that does not fit.
Status check_boxes(const Manifest& manifest, const std::filesystem::path& out);

}  // namespace tessera
