// Blocks of a file of points: where the values of a column are in memory, and how they become blocks.
#pragma once

#include <cstddef>

#include "src/base/attribute.h"
#include "src/base/big_vector.h"
#include "src/base/point.h"
#include "src/result/store/column_block.h"
#include "src/result/store/points_head.h"

namespace tessera::store {

// Finds the values of a column. `tile` is a PointsTile or a view of one.
template <class Byte, class Tile>
ColumnOf<Byte> place_in(Tile& tile, std::size_t stride_of_rows, const PointsColumn& column) {
  using What = PointsColumn::What;
  const std::size_t first = column.of == PointsColumn::Of::own ? 0 : tile.own;
  const auto at = [&](auto* values, std::size_t offset, std::size_t stride) {
    return ColumnOf<Byte>{column.type, reinterpret_cast<Byte*>(values) + first * stride + offset, stride, column.rows};
  };
  switch (column.what) {
    case What::x:
      return at(tile.points.data(), offsetof(Point, x), sizeof(Point));
    case What::y:
      return at(tile.points.data(), offsetof(Point, y), sizeof(Point));
    case What::z:
      return at(tile.points.data(), offsetof(Point, z), sizeof(Point));
    case What::id:
      return at(tile.ids.data(), 0, sizeof(PointId));
    case What::owner:
      return at(tile.owners.data(), 0, sizeof(TileId));
    case What::named:
      break;
  }
  std::size_t offset = 0;
  for (std::size_t i = 0; i < column.number; ++i) offset += size_of(tile.schema[i].type);
  return at(tile.rows.data(), offset, stride_of_rows);
}

// Appends the next column to the blocks of a file, and adds the blocks to the head.
void append_column(const Column& values, ColumnBlocks& blocks, PointsHead& head, BigVector<std::byte>& to);

}  // namespace tessera::store
