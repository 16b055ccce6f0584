// What an export of a result contains. It is counted before a file is begun, because formats have counts in their
// headers.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "src/result/export/mesh_source.h"
#include "src/result/export/vertex_numbers.h"

namespace tessera::exports {

struct Selection {
  std::vector<TileRange> ranges;  // one a tile of the manifest
  std::uint64_t vertices = 0, cells = 0;
  VertexNumbers numbers;
};

// With a filter, reads all tiles and leaves out vertices that no exported cell uses. Prepares `numbers` with a filter,
// or when `numbers_wanted`. Errors: those of reading; usage when the filter leaves nothing; interrupted.
Result<Selection> select(const MeshSource& source, bool numbers_wanted);

// Selects all of these cells; `tiles` has the main tile of each. REQUIRES: cells of a tile follow each other, and
// vertices come in the order in which cells first use them.
Selection select_all(const TileMesh& cells, std::span<const TileId> tiles);

}  // namespace tessera::exports
