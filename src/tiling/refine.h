// Splits tiles that turned out larger than the limit.
#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

#include "src/base/point.h"
#include "src/tiling/partition.h"
#include "src/tiling/routed_cloud.h"
#include "src/tiling/tile_writer.h"

namespace tessera {

// Splits `tile` in memory until each part should be below the limit. `points` are every `stride`-th of the tile.
// Returns whether the tile was split at all: a tile of equal points is not.
bool split_by_sample(Partition& partition, TileId tile, std::vector<Point> points, std::uint64_t stride,
                     std::uint64_t limit);

// Splits every tile of more than `limit` points until no such tile is left, except tiles of equal points. The points of
// split tiles are written again, and the disk space of their old records is given back. `writer` has been flushed
// before the call, and is flushed again. Uses `memory_bytes` of memory beside the writer's buffer. Errors: io, corrupt,
// interrupted.
Status split_large_tiles(Partition& partition, TileWriter& writer, const std::filesystem::path& folder,
                         std::size_t row_bytes, std::uint64_t limit, std::uint64_t memory_bytes, std::stop_token stop);

}  // namespace tessera
