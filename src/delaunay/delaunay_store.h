// What Delaunay tiles begin from and end as: routed points, and tile files of a result.
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

// A tile that is kept as points, with the counts of its cells.
struct PointsOfTile {
  std::vector<Point> points;         // the tile's own, in Hilbert order
  std::vector<PointId> ids;          // beside points
  std::vector<SharedPoint> foreign;  // vertices of its cells, in Hilbert order
  CountedCells counted;

  // Appends the foreign vertices to `points` and `ids`. Returns the owner of each point. `self`: the tile. REQUIRES: is
  // called once.
  std::vector<TileId> append_foreign(TileId self);
  std::uint64_t bytes() const {
    return points.size() * (sizeof(Point) + sizeof(PointId)) + foreign.size() * sizeof(SharedPoint);
  }
};

// Where tiles get their points and store their results. Calls for different tiles may come from different threads at
// once; calls for one tile come one after the other.
class DelaunayStore {
 public:
  virtual ~DelaunayStore() = default;
  // Returns the tile's own points. Error corrupt when they are not those that were routed.
  virtual Result<LoadedTile> load_points(TileId tile) = 0;

  // Stores the early ones of these cells. Their bytes are given to store() with the rest of the tile. May return before
  // the cells are stored; may also wait first, so that few are under way at once.
  using StoredEarly = Result<BigVector<std::byte>>;
  virtual std::future<StoredEarly> store_early(TileId tile, std::shared_ptr<const EarlyFinals> cells) = 0;
  // Takes over the bytes that store_early() returned to an earlier process or on another node. An error when the tile
  // cannot continue from what they describe.
  virtual Status take_early(TileId tile, BigVector<std::byte>& stored) = 0;

  // As Finished::store(). The receipt is the tile's entry (bytes_of() in src/result/store/tile_store.h).
  virtual void store(TileId tile, CollectedTile collected, Finished::Stored done) = 0;
  virtual void store_points(TileId tile, PointsOfTile kept, Finished::Stored done) = 0;
};

}  // namespace tessera
