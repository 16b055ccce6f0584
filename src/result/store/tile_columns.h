// Adds arrays to tile files.
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

// One value for each cell or each vertex of a tile, in the order in which TileSource returns the tile.
struct ColumnValues {
  bool of_cells = false;
  Attribute as;  // the name can be stored
  std::span<const std::byte> values;
};

struct TileCopy {
  TileId tile;
  std::filesystem::path from;
  std::filesystem::path to;          // a new file
  std::filesystem::path final_name;  // name for errors
  // The values of cells come in canonical order. In the files of large tiles the cells are not in this order.
  bool canonical = false;
};

// Writes a copy of the tile file with these columns after the arrays that it has. All other arrays are copied as they
// are stored, unchecked. Errors: corrupt, io; throws Stopped.
Result<DirectWriter::Written> copy_with_columns(const TileCopy& copy, std::span<const ColumnValues> columns,
                                                const std::stop_token& stop);
// The same for a tile that is kept as points, whose cells are always in canonical order.
Result<DirectWriter::Written> copy_points_with_columns(const TileCopy& copy, std::span<const ColumnValues> columns,
                                                       const std::stop_token& stop);

}  // namespace tessera::store
