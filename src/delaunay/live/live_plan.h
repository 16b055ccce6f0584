// What a batch does to the vertices and duplicates of a live result, as plan_update() says it of a stored one: which of
// equal points is the vertex follows the rule of the result.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "src/base/duplicate_policy.h"
#include "src/base/point.h"
#include "src/base/result.h"
#include "src/delaunay/live/live_duplicates.h"
#include "src/delaunay/live/live_exchange.h"
#include "src/delaunay/live/live_rows.h"
#include "src/delaunay/live/live_version.h"
#include "src/delaunay/update/update.h"

namespace tessera {

struct LivePlan {
  LiveBatch batch;
  std::vector<PointId> removed;             // vertices and duplicates, ascending
  std::vector<PointId> duplicates_removed;  // those that were duplicates
  // By the vertex that goes: the point that takes its place, which has been a duplicate or is new.
  std::map<PointId, PointId> heirs;
  // Vertices that a new point has replaced, and that become duplicates of it; with their attributes, if there are any.
  std::map<PointId, std::vector<std::byte>> replaced;
  // The new points that are duplicates, and those that are equal to points before them. Where the first of equal points
  // is kept, both are missing: the exchange finds them.
  std::vector<DuplicatePair> duplicates;
  std::vector<PointId> equal;
  std::map<TileId, Bounds> removed_of;  // the places of vertices that go, by owner
  std::vector<IdTiles::Entry> entries;  // of the new points
};

class LivePlanner {
 public:
  // What is there before the batch. `first_new`: the source index of the first new point. All outlive this object.
  struct Before {
    const TileSource& source;
    const LiveVersion& version;
    const LiveDuplicates& duplicates;
    const LiveRows& rows;
    StoredRows& stored;
    std::uint64_t first_new;
  };
  explicit LivePlanner(const Before& before);

  // Returns the change in which also those points are removed that are equal to new points.
  ResultChange with_equal_removed(const ResultChange& change) const;
  // Errors: usage when a point to be removed does not exist, or when a vertex would go whose duplicate would take its
  // place and has no known attributes; those of reading attributes.
  // REQUIRES: the coordinates are finite, and the attributes fit.
  Result<LivePlan> plan(const ResultChange& change);

 private:
  struct Place;
  Status plan_removal(const std::vector<PointId>& ids);
  Status add_heir(PointId vertex, const Point& at, TileId tile);
  Status place_equal_points(TileId tile, std::vector<LocalPoint>& added, std::span<const std::byte> rows);
  Status decide(TileId tile, const Place& place, std::span<const std::byte> rows, std::vector<LocalPoint>& left);
  std::optional<PointId> vertex_at(TileId tile, const Point& p) const;
  Result<std::vector<std::byte>> row_of_vertex(TileId tile, PointId id) const;
  double height_in_row(std::span<const std::byte> row) const;

  const Before before_;
  const DuplicatePolicy keep_;
  const std::size_t width_;
  const std::optional<std::size_t> height_at_;
  LivePlan plan_;
};

}  // namespace tessera
