// What a Tile is made of: a tile of a result, or cells of several in one.
#pragma once

#include <cstdint>

#include "src/result/store/tile_store.h"
#include "tessera/triangulation.h"

namespace tessera {

// "uint8", "int16", "float64", ...
const char* numpy_name(AttributeType type);

struct TileMaker {
  static Tile make(std::uint32_t id, StoredTile stored);
};

}  // namespace tessera
