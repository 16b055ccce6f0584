// Moves the columns of a tile that is kept as points into its file of cells.
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

// The columns of one tile. Immutable once it is made.
class KeptColumns {
 public:
  // Takes the columns out of the tile, which then is as it was before the first column was added. `columns`: all
  // columns of the result. REQUIRES: the tile has these columns, and its rows were read.
  KeptColumns(PointsTile& tile, const std::vector<ResultColumn>& columns);

  // Adds the columns to the tile's file, with the same bytes as if each had been added by a change of the result.
  // `entry`: of the file; is updated. Error io. Throws Stopped.
  Status put_into(const std::filesystem::path& file, TileEntry& entry, const std::stop_token& stop) const;

 private:
  struct Values {
    bool of_cells = false;
    Attribute as;
    std::vector<std::byte> values;  // by cell in canonical order, or by vertex in the order of a mesh
  };
  std::vector<Values> columns_;
};

}  // namespace tessera
