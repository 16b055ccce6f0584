// What a change does to the vertices of a result: which go, which may come to which tile, and what becomes of
// duplicates.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "src/base/big_vector.h"
#include "src/base/point.h"
#include "src/base/result.h"
#include "src/delaunay/update/old_duplicates.h"
#include "src/delaunay/update/update.h"
#include "src/result/tile_source.h"
#include "src/tiling/partition.h"
#include "src/tiling/tile/changed_points.h"

namespace tessera {

struct UpdatePlan {
  PointIds removed;                                 // vertices that go, or become duplicates
  std::set<TileId> losing;                          // the tiles that own them
  std::map<TileId, std::vector<LocalPoint>> added;  // new points, by owner
  // By the vertex that goes: the point that takes its place, which has been a duplicate, or is new. It is that of the
  // points left at the place which the policy of the result keeps.
  std::map<PointId, PointId> heirs;
  std::map<PointId, std::vector<std::byte>> heir_rows;  // attributes of heirs that have been duplicates
  // The duplicates afterwards, ascending. Where the first of equal points is kept, those among the new points are
  // missing: tiles find them (start_of() in changed_tile.h).
  std::vector<DuplicatePair> duplicates;
  bool duplicates_changed = false;
  std::uint64_t new_equal = 0;  // how many of the new points are known here to be equal to others
  // With the attributes of vertices that become duplicates. Is not in the bytes of the plan: tiles do not need it.
  OldDuplicates old;
  std::uint64_t first_new = 0;  // source index
  std::uint64_t removed_points = 0;
  std::vector<std::byte> rows;  // attributes of the new points, in the order of their source indices
  // The point that all tiles with fresh points know (docs/updates-design.md). Nothing when no points would be left.
  std::optional<SharedPoint> common;
};

// `threads` read source indices. Errors: usage when a point to be removed is no point of the result, or when the
// attributes of a duplicate would be needed, which results of older software do not keep; those of reading the result.
Result<UpdatePlan> plan_update(const TileSource& source, const Partition& partition, const ResultChange& change,
                               unsigned threads);

// The bytes are the same for the same plan. update_plan_of() returns nothing when the bytes are not those of a plan.
BigVector<std::byte> bytes_of(const UpdatePlan& plan);
std::optional<UpdatePlan> update_plan_of(std::span<const std::byte> bytes);

}  // namespace tessera
