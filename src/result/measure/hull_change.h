// Tells whether the convex hull of a result may be another one after its points have changed.
//
// The hull of all vertices stays when each vertex that has gone was in its interior, because the corners of the hull
// are still there, and each vertex that has come is in the interior of the new hull, because then no corner is new.
// Whether a vertex is on the boundary is seen in the tile that owns it: one of its cells has a facet with the vertex
// and without a cell beyond.
#pragma once

#include <atomic>
#include <functional>
#include <stop_token>
#include <utility>

#include "src/base/ids.h"
#include "src/base/result.h"
#include "src/geometry/mesh/tile_mesh.h"
#include "src/result/tile_source.h"

namespace tessera {

class HullChange {
 public:
  // `old`: the result before the change; outlives the object.
  HullChange(const TileSource& old, std::stop_token stop) : old_(old), stop_(std::move(stop)) {}

  // Looks at a tile with new cells, as it is now, or at one that has no points any more. Reads the old tile when
  // vertices of its own have gone. A vertex that has another tile now counts as one that has gone and come. Safe to
  // call from several threads. Errors: those of reading.
  Status look_at(TileId tile, const TileMesh& now);
  Status look_at_gone(TileId tile);
  // False only if the hull is the same, when all changed tiles were looked at.
  bool is_possible() const { return possible_; }

 private:
  using Which = std::function<bool(PointId)>;
  Result<bool> any_on_hull(const TileMesh& mesh, TileId tile, const Which& which) const;
  Status look_at_old(std::size_t index, const Which& gone);

  const TileSource& old_;
  std::stop_token stop_;
  std::atomic<bool> possible_ = false;
};

}  // namespace tessera
