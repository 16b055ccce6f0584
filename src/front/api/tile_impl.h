// Makes a Tile, from a tile of a result or from cells of several tiles.
#pragma once

#include <cstdint>

#include "src/result/store/tile_store.h"
#include "tessera/triangulation.h"

namespace tessera {

// Returns the name of a type in NumPy: "uint8", "int16", "float64", ...
const char* numpy_name(AttributeType type);

struct TileMaker {
  static Tile make(std::uint32_t id, StoredTile stored);
};

}  // namespace tessera
