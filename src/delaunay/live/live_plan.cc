#include "src/delaunay/live/live_plan.h"

#include <algorithm>
#include <set>
#include <string>
#include <tuple>
#include <utility>

#include "src/delaunay/update/equal_points.h"
#include "src/tiling/hilbert.h"
#include "src/tiling/kept_points.h"

namespace tessera {
namespace {

// Equal points have equal keys, so the least id comes first.
void put_points_in_hilbert_order(std::vector<LocalPoint>& points, int dimension) {
  Bounds bounds;
  for (const LocalPoint& p : points) bounds.add(p.at);
  const HilbertKey key(bounds, dimension);
  std::sort(points.begin(), points.end(), [&](const LocalPoint& a, const LocalPoint& b) {
    return std::pair(key(a.at), a.id) < std::pair(key(b.at), b.id);
  });
}

}  // namespace

// New points with equal coordinates, by source index.
struct LivePlanner::Place {
  Point at;
  std::vector<PointId> added;
};

LivePlanner::LivePlanner(const Before& before)
    : before_(before),
      keep_(before.source.manifest().keep),
      width_(row_bytes(before.source.manifest().schema)),
      height_at_(height_offset(before.source.manifest().dimension, before.source.manifest().schema)) {}

std::optional<PointId> LivePlanner::vertex_at(TileId tile, const Point& p) const {
  const auto& there = before_.version.tiles()[tile.value];
  return there ? there->own_at(p) : std::nullopt;
}

ResultChange LivePlanner::with_equal_removed(const ResultChange& change) const {
  ResultChange all = change;
  for (const Point& added : change.add) {
    const Point p = without_negative_zero(added);
    const auto vertex = vertex_at(before_.version.partition().tile_of(p), p);
    if (!vertex) continue;
    all.remove.push_back(*vertex);
    if (const auto* also = before_.duplicates.of(*vertex))
      all.remove.insert(all.remove.end(), also->begin(), also->end());
  }
  std::sort(all.remove.begin(), all.remove.end());
  all.remove.erase(std::unique(all.remove.begin(), all.remove.end()), all.remove.end());
  return all;
}

Result<LivePlan> LivePlanner::plan(const ResultChange& change) {
  plan_ = {};
  const Partition& partition = before_.version.partition();
  BOOST_OUTCOME_TRYV(plan_removal(change.remove));
  std::map<TileId, std::vector<LocalPoint>> added;
  for (std::size_t i = 0; i < change.add.size(); ++i) {
    const Point p = without_negative_zero(change.add[i]);
    const TileId tile = partition.tile_of(p);
    added[tile].push_back({p, PointId{before_.first_new + i}});
    plan_.entries.emplace_back(PointId{before_.first_new + i}, tile);
  }
  for (auto& [tile, points] : added) {
    // A later point never takes the place of the first one, and the tile itself finds equal points.
    if (keep_ != DuplicatePolicy::first) {
      BOOST_OUTCOME_TRYV(place_equal_points(tile, points, change.rows));
    }
    auto& all = plan_.batch.added[tile];  // also has heirs
    all.insert(all.end(), points.begin(), points.end());
  }
  std::erase_if(plan_.batch.added, [](const auto& tile) { return tile.second.empty(); });
  for (auto& [tile, points] : plan_.batch.added) put_points_in_hilbert_order(points, partition.dimension());
  return std::move(plan_);
}

Status LivePlanner::plan_removal(const std::vector<PointId>& ids) {
  plan_.removed = ids;
  std::sort(plan_.removed.begin(), plan_.removed.end());
  plan_.removed.erase(std::unique(plan_.removed.begin(), plan_.removed.end()), plan_.removed.end());
  for (const PointId id : plan_.removed) {
    if (before_.duplicates.has(id)) {
      plan_.duplicates_removed.push_back(id);
      continue;
    }
    const auto at = before_.version.point(id);
    if (!at)
      return error(Errc::usage, before_.source.folder().string() + ": there is no point " + to_string(id) +
                                    " to remove: no vertex and no duplicate of this result has this source index");
    const TileId tile = *before_.version.ids().find(id);
    plan_.batch.removed[tile].push_back(id);
    plan_.removed_of[tile].add(*at);
    BOOST_OUTCOME_TRYV(add_heir(id, *at, tile));
  }
  return success();
}

// The duplicate that the rule prefers takes the place of a vertex that goes.
Status LivePlanner::add_heir(PointId vertex, const Point& at, TileId tile) {
  const auto* also = before_.duplicates.of(vertex);
  if (!also) return success();
  std::optional<KeptCandidate> heir;
  for (const PointId id : *also) {
    if (std::binary_search(plan_.removed.begin(), plan_.removed.end(), id)) continue;
    KeptCandidate other{id};
    const auto* row = before_.rows.find(id);
    if (row && height_at_) other.height = height_in(*row, *height_at_);
    if (!heir || is_kept_before(keep_, other, *heir)) heir = other;
  }
  if (!heir) return success();
  if (width_ > 0 && !before_.rows.find(heir->id))
    return error(Errc::usage, before_.source.folder().string() + ": point " + to_string(vertex) +
                                  " cannot be removed alone: point " + to_string(heir->id) +
                                  " has the same coordinates and would take its place, and this result of older "
                                  "software does not have the attributes of that point; remove both");
  plan_.heirs[vertex] = heir->id;
  plan_.batch.added[tile].push_back({at, heir->id});
  return success();
}

// Afterwards no two points of the plan are equal. `added`: of the tile; those stay that are vertices where there was
// none.
Status LivePlanner::place_equal_points(TileId tile, std::vector<LocalPoint>& added, std::span<const std::byte> rows) {
  using Coordinates = std::tuple<double, double, double>;
  std::map<Coordinates, Place> places;
  for (const LocalPoint& p : added) {
    Place& place = places[{p.at.x, p.at.y, p.at.z}];
    place.at = p.at;
    place.added.push_back(p.id);
  }
  added.clear();
  for (const auto& [at, place] : places) {
    BOOST_OUTCOME_TRYV(decide(tile, place, rows, added));
  }
  return success();
}

double LivePlanner::height_in_row(std::span<const std::byte> row) const {
  return height_at_ && !row.empty() ? height_in(row, *height_at_) : 0;
}

Result<std::vector<std::byte>> LivePlanner::row_of_vertex(TileId tile, PointId id) const {
  if (width_ == 0) return std::vector<std::byte>();
  if (const auto* row = before_.rows.find(id)) return *row;
  BOOST_OUTCOME_TRY(stored, before_.stored.of(tile));
  const auto row = stored->find(id);
  if (row.empty()) return error(Errc::internal, "the attributes of vertex " + to_string(id) + " are not known");
  return std::vector<std::byte>(row.begin(), row.end());
}

// `old` is the vertex of the place unless a new point takes it: the one that stays, or the heir of one that goes.
Status LivePlanner::decide(TileId tile, const Place& place, std::span<const std::byte> rows,
                           std::vector<LocalPoint>& left) {
  const auto vertex = vertex_at(tile, place.at);
  std::optional<KeptCandidate> old;
  std::vector<std::byte> row;
  const bool goes = vertex && std::binary_search(plan_.removed.begin(), plan_.removed.end(), *vertex);
  if (vertex && !goes) {
    BOOST_OUTCOME_TRY(known, row_of_vertex(tile, *vertex));
    row = std::move(known);
    old = KeptCandidate{*vertex, height_in_row(row)};
  } else if (const auto heir = goes ? plan_.heirs.find(*vertex) : plan_.heirs.end(); heir != plan_.heirs.end()) {
    const auto* of_heir = before_.rows.find(heir->second);
    old = KeptCandidate{heir->second, of_heir ? height_in_row(*of_heir) : 0};
  }
  auto kept = old;
  for (const PointId id : place.added) {
    const KeptCandidate other{id, height_in_row(rows.subspan((id.value - before_.first_new) * width_, width_))};
    if (!kept || is_kept_before(keep_, other, *kept)) kept = other;
  }
  for (const PointId id : place.added) {
    if (id != kept->id) plan_.duplicates.push_back({id, kept->id});
    if (old || id != place.added.front()) plan_.equal.push_back(id);
  }
  if (!old) left.push_back({place.at, kept->id});
  if (!old || kept->id == old->id) return success();
  if (goes) {  // the heir stays a duplicate
    auto& of_tile = plan_.batch.added[tile];
    std::erase_if(of_tile, [&](const LocalPoint& p) { return p.id == old->id; });
  } else {
    plan_.batch.removed[tile].push_back(*vertex);
    plan_.removed_of[tile].add(place.at);
    plan_.replaced[*vertex] = std::move(row);
  }
  plan_.heirs[*vertex] = kept->id;
  plan_.batch.added[tile].push_back({place.at, kept->id});
  return success();
}

}  // namespace tessera
