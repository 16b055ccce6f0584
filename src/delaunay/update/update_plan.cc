#include "src/delaunay/update/update_plan.h"

#include <algorithm>
#include <atomic>
#include <mutex>
#include <string>
#include <tuple>
#include <utility>

#include "src/base/flat_codec.h"
#include "src/base/on_threads.h"
#include "src/delaunay/update/equal_points.h"
#include "src/tiling/kept_points.h"
#include "src/tiling/tile/known_from_start.h"

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

// Finds the vertices that go, and how many each tile loses. Reads the source indices of tiles until all are found.
Result<std::map<TileId, std::uint64_t>> find_vertices(const TileSource& source, const PointIds& vertices,
                                                      unsigned threads, UpdatePlan& plan) {
  std::mutex mutex;
  std::map<TileId, std::uint64_t> lost;
  std::atomic<std::uint64_t> found{0};
  std::atomic<std::size_t> next{0};
  std::atomic<bool> failed{false};
  BOOST_OUTCOME_TRYV(on_threads(threads, failed, [&]() -> Status {
    for (std::size_t i = next++; i < source.tiles() && found < vertices.size() && !failed; i = next++) {
      BOOST_OUTCOME_TRY(ids, source.read_own_ids(i));
      std::erase_if(ids, [&](PointId id) { return !vertices.contains(id); });
      if (ids.empty()) continue;
      found += ids.size();
      const std::lock_guard lock(mutex);
      plan.removed.insert(ids);
      plan.losing.insert(source.entry(i).tile);
      lost[source.entry(i).tile] = ids.size();
    }
    return success();
  }));
  if (plan.removed.size() == vertices.size()) return lost;
  std::optional<PointId> least;
  for (const PointId id : vertices.sorted()) {
    if (!plan.removed.contains(id) && (!least || id < *least)) least = id;
  }
  return error(Errc::usage, source.folder().string() + ": there is no point " + to_string(*least) +
                                " to remove: no vertex and no duplicate of this result has this source index");
}

// Any old point that stays will do. It is looked for in the tiles that are read anyway, and then in others, the
// smallest first, as they are read fastest. A new point is taken only when no old point stays. `lost`: how many points
// tiles lose at least.
Status choose_common(const TileSource& source, const std::map<TileId, std::uint64_t>& lost, UpdatePlan& plan) {
  std::vector<std::tuple<bool, std::uint64_t, std::size_t>> order;
  for (std::size_t i = 0; i < source.tiles(); ++i) {
    const TileEntry& entry = source.entry(i);
    const auto losing = lost.find(entry.tile);
    if (losing == lost.end() || losing->second < entry.own_points)
      order.emplace_back(losing == lost.end() && !plan.added.contains(entry.tile), entry.own_points, i);
  }
  std::sort(order.begin(), order.end());
  for (const auto& [apart, points, i] : order) {
    BOOST_OUTCOME_TRY(stored, source.read(i, {.cells = false}));
    for (std::size_t v = 0; v < stored.mesh.ids.size() && !plan.common; ++v) {
      if (stored.mesh.point_ghost[v] == 0 && !plan.removed.contains(stored.mesh.ids[v]))
        plan.common = SharedPoint{stored.mesh.points[v], stored.mesh.ids[v], source.entry(i).tile, 0};
    }
    if (plan.common) return success();
  }
  for (std::size_t i = 0; i < source.tiles() && !plan.heirs.empty() && !plan.common; ++i) {
    BOOST_OUTCOME_TRY(stored, source.read(i, {.cells = false}));
    for (std::size_t v = 0; v < stored.mesh.ids.size() && !plan.common; ++v) {
      const auto heir = plan.heirs.find(stored.mesh.ids[v]);
      if (stored.mesh.point_ghost[v] == 0 && heir != plan.heirs.end())
        plan.common = SharedPoint{stored.mesh.points[v], heir->second, source.entry(i).tile, fresh_bit};
    }
  }
  for (const auto& [tile, points] : plan.added) {  // of equal points the first is the vertex
    if (!plan.common) plan.common = SharedPoint{points.front().at, points.front().id, tile, fresh_bit};
  }
  return success();
}

}  // namespace

Result<UpdatePlan> plan_update(const TileSource& source, const Partition& partition, const ResultChange& change,
                               unsigned threads) {
  UpdatePlan plan;
  BOOST_OUTCOME_TRY(old, OldDuplicates::open(source));
  plan.old = std::move(old);
  const PointIds wanted(change.remove);
  plan.removed.reserve(change.remove);
  plan.removed_points = wanted.size();
  BOOST_OUTCOME_TRY(vertices, remove_duplicates(source, wanted, plan));
  BOOST_OUTCOME_TRY(lost, find_vertices(source, vertices, threads, plan));
  plan.first_new = source.manifest().points_read;
  for (std::size_t i = 0; i < change.add.size(); ++i) {
    const Point p = without_negative_zero(change.add[i]);
    plan.added[partition.tile_of(p)].push_back({p, PointId{plan.first_new + i}});
  }
  plan.rows = change.rows;
  // A later point never takes the place of the first one.
  if (source.manifest().keep != DuplicatePolicy::first) {
    BOOST_OUTCOME_TRYV(place_equal_points(source, change.rows, plan));
  }
  for (const auto& [vertex, heir] : plan.heirs) {
    const auto row = plan.old.row(heir);
    if (heir < PointId{plan.first_new} && row) plan.heir_rows[heir].assign(row->begin(), row->end());
  }
  BOOST_OUTCOME_TRYV(choose_common(source, lost, plan));
  return plan;
}

BigVector<std::byte> bytes_of(const UpdatePlan& plan) {
  FlatWriter out;
  out.list(plan.removed.sorted());
  out.list(std::vector<TileId>(plan.losing.begin(), plan.losing.end()));
  out.value(static_cast<std::uint64_t>(plan.added.size()));
  for (const auto& [tile, points] : plan.added) {
    out.value(tile);
    out.list(points);
  }
  std::vector<std::uint64_t> heirs;
  for (const auto& [vertex, heir] : plan.heirs) heirs.insert(heirs.end(), {vertex.value, heir.value});
  out.list(heirs);
  std::vector<PointId> with_rows;
  std::vector<std::byte> heir_rows;
  for (const auto& [heir, row] : plan.heir_rows) {
    with_rows.push_back(heir);
    heir_rows.insert(heir_rows.end(), row.begin(), row.end());
  }
  out.list(with_rows);
  out.list(heir_rows);
  out.list(plan.duplicates);
  out.value(static_cast<std::uint8_t>(plan.duplicates_changed ? 1 : 0));
  out.value(plan.new_equal);
  out.value(plan.first_new);
  out.value(plan.removed_points);
  out.list(plan.rows);
  out.value(static_cast<std::uint8_t>(plan.common ? 1 : 0));
  out.value(plan.common.value_or(SharedPoint{}));
  return out.take();
}

std::optional<UpdatePlan> update_plan_of(std::span<const std::byte> bytes) {
  FlatReader in(bytes);
  UpdatePlan plan;
  std::vector<PointId> removed;
  std::vector<TileId> losing;
  std::uint64_t tiles = 0;
  if (!in.list(removed) || !in.list(losing) || !in.value(tiles)) return std::nullopt;
  for (std::uint64_t i = 0; i < tiles; ++i) {
    TileId tile;
    std::vector<LocalPoint> points;
    if (!in.value(tile) || !in.list(points) || points.empty()) return std::nullopt;
    plan.added[tile] = std::move(points);
  }
  std::vector<std::uint64_t> heirs;
  std::vector<PointId> with_rows;
  std::vector<std::byte> heir_rows;
  std::uint8_t duplicates_changed = 0, has_common = 0;
  SharedPoint common;
  const bool read = in.list(heirs) && in.list(with_rows) && in.list(heir_rows) && in.list(plan.duplicates) &&
                    in.value(duplicates_changed) && in.value(plan.new_equal) && in.value(plan.first_new) &&
                    in.value(plan.removed_points) && in.list(plan.rows) && in.value(has_common) && in.value(common) &&
                    in.at_end();
  if (!read || heirs.size() % 2 != 0) return std::nullopt;
  if (with_rows.empty() ? !heir_rows.empty() : heir_rows.size() % with_rows.size() != 0) return std::nullopt;
  const std::size_t width = with_rows.empty() ? 0 : heir_rows.size() / with_rows.size();
  for (std::size_t i = 0; i < with_rows.size(); ++i) {
    const auto row = std::span(heir_rows).subspan(i * width, width);
    plan.heir_rows[with_rows[i]].assign(row.begin(), row.end());
  }
  for (std::size_t i = 0; i < heirs.size(); i += 2) plan.heirs[PointId{heirs[i]}] = PointId{heirs[i + 1]};
  plan.removed = PointIds(removed);
  plan.losing.insert(losing.begin(), losing.end());
  plan.duplicates_changed = duplicates_changed != 0;
  if (has_common != 0) plan.common = common;
  return plan;
}

}  // namespace tessera
