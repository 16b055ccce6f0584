// What Delaunay tiles begin from and what they end as: points that were routed, tile files of a result.
#pragma once

#include <cstddef>
#include <future>
#include <memory>
#include <vector>

#include "src/base/big_vector.h"
#include "src/base/ids.h"
#include "src/base/point.h"
#include "src/base/result.h"
#include "src/exchange/tile_program.h"
#include "src/result/store/tile_store.h"
#include "src/tiling/routed_cloud.h"
#include "src/tiling/tile/collected_tile.h"
#include "src/tiling/tile/early_finals.h"

namespace tessera {

// A tile of which points are kept, and of its cells what was counted.
struct PointsOfTile {
  std::vector<Point> points;         // the tile's own, in Hilbert order
  std::vector<PointId> ids;          // theirs
  std::vector<SharedPoint> foreign;  // vertices of its cells, in Hilbert order
  CountedCells counted;

  // Foreign vertices follow the own points in `points` and `ids` from then on. Returns who owns each of all. `self`:
  // the tile. To be called once.
  std::vector<TileId> append_foreign(TileId self);
  std::uint64_t bytes() const {
    return points.size() * (sizeof(Point) + sizeof(PointId)) + foreign.size() * sizeof(SharedPoint);
  }
};

// Calls for different tiles may come from different threads at once; those for one tile come one after the other.
class DelaunayStore {
 public:
  virtual ~DelaunayStore() = default;
  // Error corrupt when the points are not those that were routed.
  virtual Result<LoadedTile> load_points(TileId tile) = 0;

  // Keeps the early ones of these cells for store(), which gets what comes of this with the rest of the tile. May
  // return before, and wait before it does, so that few are under way.
  using StoredEarly = Result<BigVector<std::byte>>;
  virtual std::future<StoredEarly> store_early(TileId tile, std::shared_ptr<const EarlyFinals> cells) = 0;
  // The same bytes, of an earlier process or another node: an error when what they tell of cannot be gone on with.
  virtual Status take_early(TileId tile, BigVector<std::byte>& stored) = 0;

  // As Finished::store(): the receipt is the tile's entry (bytes_of() in src/result/store/tile_store.h).
  virtual void store(TileId tile, CollectedTile collected, Finished::Stored done) = 0;
  virtual void store_points(TileId tile, PointsOfTile kept, Finished::Stored done) = 0;
};

}  // namespace tessera
