// Computes the columns of a result again for tiles that have changed. A measure of a cell depends on the cell alone,
// and a measure of a vertex on the cells around it. So values of other tiles stay what they were.
#pragma once

#include <cstddef>
#include <memory>
#include <stop_token>
#include <utility>
#include <vector>

#include "src/base/result.h"
#include "src/result/measure/tile_measure.h"
#include "src/result/pass.h"
#include "src/result/store/tile_store.h"
#include "src/result/tile_source.h"

namespace tessera {

// Whether the column's values depend only on cells, or on the cells around each vertex. Densities also depend on
// duplicates and attributes, and do not count.
bool can_be_made_again(const ResultColumn& column);

class ColumnsAgain {
 public:
  // For tiles of `source`, which must outlive the object. REQUIRES: each of the columns can_be_made_again(). Error
  // internal when nothing makes one of them.
  static Result<ColumnsAgain> of(const TileSource& source, const std::vector<ResultColumn>& columns,
                                 const std::stop_token& stop);
  // The values of a tile in the order of the columns: of all cells, and of the own vertices. Safe to call from several
  // threads for different tiles. Errors: those of TileMeasure::of().
  Result<PassValues> values(std::size_t index, const StoredTile& tile);

 private:
  ColumnsAgain(const TileSource& source, std::stop_token stop) : source_(source), stop_(std::move(stop)) {}
  const TileSource& source_;
  std::stop_token stop_;
  std::vector<std::unique_ptr<TileMeasure>> measures_;
  std::vector<std::size_t> places_;  // by column: its place among those of the measures
};

}  // namespace tessera
