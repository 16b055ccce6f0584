// Rasters by natural neighbours, drawn tile by tile. The neighbours of a pixel near the border of its tile may be in
// other tiles, which are read then, and kept as long as memory allows.
#pragma once

#include <atomic>
#include <cstdint>
#include <stop_token>

#include "src/base/result.h"
#include "src/result/export/cell_filter.h"
#include "src/result/query/column.h"
#include "src/result/query/tile_cache.h"
#include "src/result/query/walker.h"
#include "src/result/terrain/blocks.h"
#include "src/result/terrain/dem_method.h"
#include "src/result/terrain/drawing.h"
#include "src/result/terrain/grid.h"
#include "src/result/tile_queue.h"

namespace tessera::terrain {

// Draws the pixels that Drawing draws, with other values: each is that of natural_value.h for its centre. A pixel on an
// edge of the hull has the linear value, and one on a vertex the value of the vertex. A pixel without a value: a
// neighbour's value is not finite; or, in a region, its neighbours are not all known.
class NaturalDrawing {
 public:
  // References must stay valid as long as this object.
  NaturalDrawing(const query::Column& column, const Grid& grid, const DrawingOptions& options, DemMethod method,
                 std::stop_token stop, Consumer take);

  // Draws the tiles of a queue. Errors: those of Drawing::run().
  Status run(TileQueue& tiles);
  std::uint64_t left_out() const { return left_out_; }  // cells left out because of their edges
  // Pixels without a value because the region does not know all their neighbours.
  std::uint64_t unknown() const { return unknown_; }

 private:
  class Thread;

  query::Column column_;
  Grid grid_;
  DrawingOptions options_;
  DemMethod method_;
  std::stop_token stop_;
  Consumer take_;
  exports::CellFilter filter_;
  std::uint64_t blocks_bytes_ = 0;  // of a thread
  std::atomic<std::uint64_t> left_out_{0}, unknown_{0};
};

}  // namespace tessera::terrain
