// Reads and writes tiles/NNNNNN.pts: a tile as its points, packed. FORMAT.md has the grammar.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "src/base/big_vector.h"
#include "src/base/result.h"
#include "src/result/store/data_file.h"
#include "src/result/store/points_head.h"
#include "src/result/store/points_tile.h"

namespace tessera {

// The whole file of a tile without columns of cells. Equal tiles give equal bytes with the same version of zstd.
// REQUIRES: at most 2^31 points, and at most 2^31 cells.
BigVector<std::byte> points_file_bytes(const PointsTileView& tile);

// Selects what is read of a file in addition to the points.
struct PointsFields {
  bool rows = true;
  bool cell_columns = true;
};

// Each of these functions reads no more of the file than it needs. Errors: io; corrupt when the file is not of this
// tile, or when anything that was read is impossible. The memory needed is proportional to the numbers of points and
// cells, for which the file has blocks. But a block may be small. So a caller that does not trust the file, and knows
// the right numbers, reads the head first.
Result<store::PointsHead> read_points_head(DataFile file, TileId tile);
Result<PointsTile> read_points_file(DataFile file, TileId tile, const PointsFields& fields);
// Reads the source indices of the own points, in the file's order.
Result<std::vector<PointId>> read_own_point_ids(DataFile file, TileId tile);
// The same for files on a disk.
Result<store::PointsHead> read_points_head(const std::filesystem::path& path, TileId tile);
Result<PointsTile> read_points_file(const std::filesystem::path& path, TileId tile, const PointsFields& fields);
Result<std::vector<PointId>> read_own_point_ids(const std::filesystem::path& path, TileId tile);

// Reads a file that is in memory; `name` is for errors.
Result<PointsTile> parse_points_file(std::span<const std::byte> bytes, const std::filesystem::path& name, TileId tile);

// The indices of the points in ascending order of their ids. Foreign points have this order in a mesh, whatever the
// file's order.
std::vector<std::uint32_t> by_id(std::span<const PointId> ids);

}  // namespace tessera
