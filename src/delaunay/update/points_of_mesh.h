// Of which kind the file of a changed tile is; and writes a tile that has its cells as one that is kept as points.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "src/base/result.h"
#include "src/geometry/mesh/tile_mesh.h"
#include "src/result/store/tile_store.h"
#include "src/result/tile_source.h"

namespace tessera {

// Returns the kind that the tile has in the result. A tile without a file gets one like the others.
TileKind kind_in(const TileSource& result, TileId tile);

// `rows`: mesh.points.size() rows of options.schema. Errors: those of write_points_tile().
Result<TileEntry> write_as_points(const std::filesystem::path& out, TileId tile, const TileMesh& mesh,
                                  std::span<const std::byte> rows, const StoreOptions& options);

}  // namespace tessera
