// tiles/NNNNNN.pts: a tile as its points, packed. FORMAT.md gives its grammar.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "src/base/big_vector.h"
#include "src/base/result.h"
#include "src/result/store/points_head.h"
#include "src/result/store/points_tile.h"

namespace tessera {

// The whole file of a tile without columns of cells. Equal tiles make equal bytes, with one version of zstd. REQUIRES:
// at most 2^31 points, and cells.
BigVector<std::byte> points_file_bytes(const PointsTileView& tile);

// What is read of a file beside the points.
struct PointsParts {
  bool rows = true;
  bool cell_columns = true;
};

// Each of them reads no more of the file than it needs. Errors: io; corrupt when it is not the file of this tile, or
// anything that was looked at cannot be. Memory is taken in proportion to the numbers of points and cells, for which
// the file has blocks; a block may be small. Who does not trust a file, and knows how many it should have, looks at its
// head first.
Result<store::PointsHead> read_points_head(const std::filesystem::path& path, TileId tile);
Result<PointsTile> read_points_file(const std::filesystem::path& path, TileId tile, const PointsParts& parts);
// Of the own points, in the file's order.
Result<std::vector<PointId>> read_own_point_ids(const std::filesystem::path& path, TileId tile);

// All of a file in memory; `name` is for errors.
Result<PointsTile> parse_points_file(std::span<const std::byte> bytes, const std::filesystem::path& name, TileId tile);

// The places of points from the least id to the greatest: so foreign ones stand in a mesh, whatever the file's order.
std::vector<std::uint32_t> by_id(std::span<const PointId> ids);

}  // namespace tessera
