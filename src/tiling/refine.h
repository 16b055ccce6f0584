// Splitting tiles that turned out larger than the limit.
#pragma once

#include <cstdint>
#include <stop_token>

#include "src/tiling/routed_cloud.h"
#include "src/tiling/tile_writer.h"

namespace tessera {

// Splits every tile of more than `limit` points until none is left, or only those of equal points, and writes them
// anew; the disk of their old records is given back. `writer` has been flushed, and is flushed again. Memory:
// `memory_bytes` beside the writer's buffer.
Status split_large_tiles(Partition& partition, TileWriter& writer, const std::filesystem::path& folder,
                         std::size_t row_bytes, std::uint64_t limit, std::uint64_t memory_bytes, std::stop_token stop);

}  // namespace tessera
