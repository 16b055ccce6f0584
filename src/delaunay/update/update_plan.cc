#include "src/delaunay/update/update_plan.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "src/delaunay/update/equal_points.h"
#include "src/tiling/kept_points.h"

namespace tessera {
namespace {

// Sorts out which of the points to be removed are duplicates, and which duplicates take the places of vertices. Returns
// the points that must be vertices.
Result<PointIds> remove_duplicates(const TileSource& source, const PointIds& wanted, UpdatePlan& plan) {
  const Manifest& manifest = source.manifest();
  const std::optional<std::size_t> height_at = height_offset(manifest.dimension, manifest.schema);
  PointIds vertices = wanted;
  std::map<PointId, KeptCandidate> heirs;
  const auto& pairs = plan.old.pairs();
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (wanted.contains(pairs[i].duplicate)) {
      vertices.erase(pairs[i].duplicate);
      plan.duplicates_changed = true;
    } else if (wanted.contains(pairs[i].kept)) {
      KeptCandidate other{pairs[i].duplicate};
      if (height_at && plan.old.has_rows()) other.height = height_in(plan.old.row_of(i), *height_at);
      const auto [heir, first] = heirs.emplace(pairs[i].kept, other);
      if (!first && is_kept_before(manifest.keep, other, heir->second)) heir->second = other;
      plan.duplicates_changed = true;
    }
  }
  for (const auto& [vertex, heir] : heirs) plan.heirs[vertex] = heir.id;
  if (!plan.heirs.empty() && !manifest.schema.empty() && !plan.old.has_rows())
    return error(Errc::usage,
                 source.folder().string() + ": point " + to_string(plan.heirs.begin()->first) +
                     " cannot be removed alone: point " + to_string(plan.heirs.begin()->second) +
                     " has the same coordinates and would take its place, and results of older software do not keep "
                     "the attributes of such points; remove both, or triangulate again");
  for (const DuplicatePair& pair : pairs) {
    if (wanted.contains(pair.duplicate)) continue;
    const auto heir = plan.heirs.find(pair.kept);
    if (heir == plan.heirs.end()) {
      plan.duplicates.push_back(pair);
    } else if (heir->second != pair.duplicate) {
      plan.duplicates.push_back({pair.duplicate, heir->second});
    }
  }
  return vertices;
}

// The tiles of the vertices that go. Reads the source indices of tiles until all are found.
Status find_vertices(const TileSource& source, PointIds missing, UpdatePlan& plan) {
  for (std::size_t i = 0; i < source.tiles() && !missing.empty(); ++i) {
    BOOST_OUTCOME_TRY(ids, source.read_own_ids(i));
    for (const PointId id : ids) {
      if (missing.erase(id) == 0) continue;
      plan.removed.insert(id);
      plan.losing.insert(source.entry(i).tile);
    }
  }
  if (missing.empty()) return success();
  const PointId least = *std::min_element(missing.begin(), missing.end());
  return error(Errc::usage, source.folder().string() + ": there is no point " + to_string(least) +
                                " to remove: no vertex and no duplicate of this result has this source index");
}

}  // namespace

Result<UpdatePlan> plan_update(const TileSource& source, const Partition& partition, const ResultChange& change) {
  UpdatePlan plan;
  BOOST_OUTCOME_TRY(old, OldDuplicates::open(source));
  plan.old = std::move(old);
  const PointIds wanted(change.remove.begin(), change.remove.end());
  plan.removed_points = wanted.size();
  BOOST_OUTCOME_TRY(vertices, remove_duplicates(source, wanted, plan));
  BOOST_OUTCOME_TRYV(find_vertices(source, std::move(vertices), plan));
  plan.first_new = source.manifest().points_read;
  for (std::size_t i = 0; i < change.add.size(); ++i) {
    const Point p = without_negative_zero(change.add[i]);
    plan.added[partition.tile_of(p)].push_back({p, PointId{plan.first_new + i}});
  }
  // A later point never takes the place of the first one.
  if (source.manifest().keep != DuplicatePolicy::first) {
    BOOST_OUTCOME_TRYV(place_equal_points(source, change.rows, plan));
  }
  return plan;
}

}  // namespace tessera
