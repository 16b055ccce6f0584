// Columns of a tile that is kept as points, on their way into its file of cells.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <stop_token>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/result.h"
#include "src/result/store/points_tile.h"
#include "src/result/store/tile_store.h"

namespace tessera {

class KeptColumns {
 public:
  // Takes them out of the tile, which then is as it was before any of them came. `columns`: all of the result.
  // REQUIRES: the tile has them, and its rows.
  KeptColumns(PointsTile& tile, const std::vector<ResultColumn>& columns);

  // Puts them into the tile's file, as one change of the result after the other would have put them. `entry`: of the
  // file; then of what it has become. Error io; Stopped is thrown.
  Status put_into(const std::filesystem::path& file, TileEntry& entry, const std::stop_token& stop) const;

 private:
  struct Values {
    bool of_cells = false;
    Attribute as;
    std::vector<std::byte> values;  // by cell in canonical order, or by vertex as a mesh has them
  };
  std::vector<Values> columns_;
};

}  // namespace tessera
