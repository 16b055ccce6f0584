// Writes a tile that has its cells as a tile that is kept as points.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "src/base/result.h"
#include "src/geometry/mesh/tile_mesh.h"
#include "src/result/store/tile_store.h"

namespace tessera {

// `rows`: mesh.points.size() rows of options.schema. Errors: those of write_points_tile().
Result<TileEntry> write_as_points(const std::filesystem::path& out, TileId tile, const TileMesh& mesh,
                                  std::span<const std::byte> rows, const StoreOptions& options);

}  // namespace tessera
