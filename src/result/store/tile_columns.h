// Tile files with more arrays than they had.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <stop_token>

#include "src/base/attribute.h"
#include "src/base/ids.h"
#include "src/base/result.h"
#include "src/result/store/direct_writer.h"

namespace tessera::store {

// One value for each cell of a tile, or for each vertex, in the order of the tile that TileSource gives.
struct ColumnValues {
  bool of_cells = false;
  Attribute as;  // under a name that can be stored
  std::span<const std::byte> values;
};

struct TileCopy {
  TileId tile;
  std::filesystem::path from;
  std::filesystem::path to;          // a new file
  std::filesystem::path final_name;  // that errors speak of
  // Values of cells come in canonical order, in which those of large tiles do not stand in files.
  bool canonical = false;
};

// Writes the tile file with these columns behind those that it has. All other arrays are copied as they are stored.
// Nothing in them is checked. Errors: corrupt, io; Stopped is thrown.
Result<DirectWriter::Written> copy_with_columns(const TileCopy& copy, std::span<const ColumnValues> columns,
                                                const std::stop_token& stop);
// The same of a tile that is kept as points, whose cells are always in canonical order.
Result<DirectWriter::Written> copy_points_with_columns(const TileCopy& copy, std::span<const ColumnValues> columns,
                                                       const std::stop_token& stop);

}  // namespace tessera::store
