#include "src/delaunay/update/update_plan.h"

#include <algorithm>
#include <string>
#include <utility>

namespace tessera {
namespace {

// Sorts out which of the points to be removed are duplicates. Returns those that must be vertices.
Result<PointIds> remove_duplicates(const TileSource& source, const PointIds& wanted, UpdatePlan& plan) {
  const Manifest& manifest = source.manifest();
  PointIds vertices = wanted;
  if (manifest.duplicates_xxh3 == 0) return vertices;
  BOOST_OUTCOME_TRY(pairs, read_duplicates(source.folder(), manifest));
  for (const DuplicatePair& pair : pairs) {  // ascending
    if (wanted.contains(pair.duplicate)) {
      vertices.erase(pair.duplicate);
      plan.duplicates_changed = true;
      continue;
    }
    DuplicatePair left = pair;
    if (wanted.contains(pair.kept)) {
      const auto [heir, first] = plan.heirs.emplace(pair.kept, pair.duplicate);
      plan.duplicates_changed = true;
      if (first) continue;
      left.kept = heir->second;
    }
    plan.duplicates.push_back(left);
  }
  if (!plan.heirs.empty() && !manifest.schema.empty())
    return error(Errc::usage,
                 source.folder().string() + ": point " + to_string(plan.heirs.begin()->first) +
                     " cannot be removed alone: point " + to_string(plan.heirs.begin()->second) +
                     " has the same coordinates and would take its place, and results do not keep the attributes of "
                     "such points; remove both");
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
  const PointIds wanted(change.remove.begin(), change.remove.end());
  plan.removed_points = wanted.size();
  if (!wanted.empty()) {
    BOOST_OUTCOME_TRY(vertices, remove_duplicates(source, wanted, plan));
    BOOST_OUTCOME_TRYV(find_vertices(source, std::move(vertices), plan));
  } else if (source.manifest().duplicates_xxh3 != 0) {
    BOOST_OUTCOME_TRY(pairs, read_duplicates(source.folder(), source.manifest()));
    plan.duplicates = std::move(pairs);
  }
  plan.first_new = source.manifest().points_read;
  for (std::size_t i = 0; i < change.add.size(); ++i) {
    const Point p = without_negative_zero(change.add[i]);
    plan.added[partition.tile_of(p)].push_back({p, PointId{plan.first_new + i}});
  }
  return plan;
}

}  // namespace tessera
