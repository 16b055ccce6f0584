// What of a result is exported, counted before a file is begun: formats tell counts in their heads.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "src/result/export/mesh_source.h"
#include "src/result/export/vertex_numbers.h"

namespace tessera::exports {

struct Selection {
  std::vector<Part> parts;  // as the manifest's tiles
  std::uint64_t vertices = 0, cells = 0;
  VertexNumbers numbers;
};

// With a filter reads all tiles, and leaves out vertices that no cell needs any more. Prepares `numbers` with a filter,
// or when they are wanted. Errors: of reading; usage when the filter leaves nothing; interrupted.
Result<Selection> select(const MeshSource& source, bool numbers_wanted);

// All of these cells, of the main tiles `tiles`. REQUIRES: those of a tile stand together, and vertices come in the
// order in which the cells use them first.
Selection select_all(const TileMesh& cells, std::span<const TileId> tiles);

}  // namespace tessera::exports
