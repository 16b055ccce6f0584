// Writes a tile that is kept as points.
#include <algorithm>
#include <cstring>
#include <optional>
#include <span>

#include "src/base/files/names.h"
#include "src/base/files/temporary.h"
#include "src/base/files/whole_file.h"
#include "src/base/stopped.h"
#include "src/result/store/direct_writer.h"
#include "src/result/store/manifest.h"
#include "src/result/store/points_file.h"
#include "src/result/store/tile_layout.h"
#include "src/result/store/tile_store.h"

namespace tessera {

namespace fs = std::filesystem;
using namespace store;

namespace {

// The range of the heights of the tile's own vertices.
std::optional<HeightRange> heights_of(const PointsTileView& tile) {
  const Attribute wanted{"z", AttributeType::f64};
  const auto z = std::find(tile.schema.begin(), tile.schema.end(), wanted);
  if (tile.dimension != 2 || z == tile.schema.end()) return std::nullopt;
  std::size_t stride = 0, offset = 0;
  for (auto at = tile.schema.begin(); at != tile.schema.end(); ++at) {
    if (at == z) offset = stride;
    stride += size_of(at->type);
  }
  std::optional<HeightRange> range;
  for (std::size_t i = 0; i < tile.own; ++i) {
    double height = 0;
    std::memcpy(&height, tile.rows.data() + i * stride + offset, sizeof height);
    widen(range, height);
  }
  return range;
}

}  // namespace

Result<TileEntry> write_points_tile(const fs::path& out, const PointsTileView& tile, const CountedCells& counted,
                                    const StoreOptions& options) {
  BOOST_OUTCOME_TRY(schema, stored_schema(options.schema));
  const PointsTileView stored{tile.dimension, tile.tile, tile.own,  tile.points,  tile.ids,
                              tile.owners,    schema,    tile.rows, counted.cells};
  const std::size_t n = stored.points.size();
  if (stored.own > n || stored.ids.size() != n || stored.owners.size() != n ||
      stored.rows.size() != n * row_bytes(schema))
    return error(Errc::internal, "a tile's arrays do not fit together");
  TileEntry entry;
  entry.tile = tile.tile;
  entry.kind = TileKind::points;
  entry.points = n;
  entry.own_points = stored.own;
  entry.cells = counted.cells;
  entry.main_cells = counted.main_cells;
  entry.digest = counted.digest;
  *entry.digest += digest_of(stored.dimension, stored.points.first(stored.own), stored.ids.first(stored.own));
  entry.heights = heights_of(stored);
  const fs::path final_name = tile_file(out, entry);
  BOOST_OUTCOME_TRYV(make_directories(final_name.parent_path()));
  throw_if_stopped(options.stop);
  const auto bytes = points_file_bytes(stored);
  TemporaryFile temporary(temporary_name_of_process(final_name));
  BOOST_OUTCOME_TRY(file, DirectWriter::create(temporary.path(), final_name, options.stop));
  BOOST_OUTCOME_TRYV(file.append(bytes));
  BOOST_OUTCOME_TRY(written, file.finish());
  entry.bytes = written.bytes;
  entry.xxh3 = written.xxh3;
  BOOST_OUTCOME_TRYV(publish_tile(out, temporary, entry, options));
  return entry;
}

}  // namespace tessera
