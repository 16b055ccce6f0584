// The surface of a 2D result, drawn on a grid of pixels, tile by tile.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>
#include <utility>

#include "src/base/result.h"
#include "src/result/export/cell_filter.h"
#include "src/result/query/column.h"
#include "src/result/terrain/blocks.h"
#include "src/result/terrain/grid.h"
#include "src/result/tile_queue.h"
#include "src/result/tile_source.h"

namespace tessera::terrain {

struct DrawingOptions {
  std::optional<double> max_edge = {};    // cells with a longer edge in the plane have no pixels
  std::optional<double> max_radius = {};  // and cells with a larger circumradius
  bool doubles = false;                   // else values are rounded to 32 bits
  std::uint64_t memory_bytes = 0;         // at least the memory of one tile is used
  unsigned threads = 1;
};

// Receives the pixels that were drawn. Called by several threads.
using Consumer = std::function<Status(Blocks&)>;

// Draws cells. Which cell has a pixel, and the value, depends only on the triangulation (cell_raster.h).
class Drawing {
 public:
  // References must stay valid as long as this object.
  Drawing(const std::filesystem::path& out, const Manifest& manifest, const query::Column& column, const Grid& grid,
          const DrawingOptions& options, std::stop_token stop, Consumer take)
      : out_(out),
        manifest_(manifest),
        column_(column),
        row_bytes_(row_bytes(manifest.schema)),
        grid_(grid),
        options_(options),
        stop_(std::move(stop)),
        take_(std::move(take)),
        filter_({options.max_edge, options.max_radius}),
        blocks_bytes_(std::max<std::uint64_t>(options.memory_bytes / options.threads, blocks_least)) {}

  // The first run() draws cells in memory, all those that may have a pixel; the second draws the tiles of a queue. Both
  // may be called by up to options.threads threads at once. Errors: corrupt when cells overlap, or when a tile is not
  // what the manifest says; io; interrupted; those of `take`.
  Status run(const StoredTile& cells);
  Status run(TileQueue& tiles);
  std::uint64_t left_out() const { return left_out_; }  // cells left out because of their edges

 private:
  static constexpr std::uint64_t blocks_least = 16 * sizeof(Block);

  Status draw(const TileSource& source, std::size_t index, Blocks& blocks);
  // `from` is the file of the cells, for errors.
  Status draw(const StoredTile& tile, const std::filesystem::path& from, Blocks& blocks);

  const std::filesystem::path& out_;
  const Manifest& manifest_;
  query::Column column_;
  std::size_t row_bytes_;
  Grid grid_;
  DrawingOptions options_;
  std::stop_token stop_;
  Consumer take_;
  exports::CellFilter filter_;
  std::uint64_t blocks_bytes_;  // of a thread
  std::atomic<std::uint64_t> left_out_{0};
};

}  // namespace tessera::terrain
