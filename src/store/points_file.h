// tiles/NNNNNN.pts: a tile as its points, packed. FORMAT.md gives its grammar.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "src/base/big_vector.h"
#include "src/base/result.h"
#include "src/store/points_head.h"
#include "src/store/points_tile.h"

namespace tessera {

// The whole file. Equal tiles make equal bytes, with one version of zstd. REQUIRES: at most 2^31 points.
BigVector<std::byte> points_file_bytes(const PointsTileView& tile);

// Each of them reads no more of the file than it needs. Errors: io; corrupt when it is not the file of this tile, or
// anything that was looked at is not what points_file_bytes() makes. Memory is taken in proportion to the number of
// points, for which the file has blocks; a block may be small. Who does not trust a file, and knows how many it should
// have, looks at its head first.
Result<store::PointsHead> read_points_head(const std::filesystem::path& path, TileId tile);
Result<PointsTile> read_points_file(const std::filesystem::path& path, TileId tile, bool attributes);
// Of the own points, in the file's order.
Result<std::vector<PointId>> read_own_point_ids(const std::filesystem::path& path, TileId tile);

// Of a file in memory; `name` is for errors.
Result<PointsTile> parse_points_file(std::span<const std::byte> bytes, const std::filesystem::path& name, TileId tile,
                                     bool attributes);

}  // namespace tessera
