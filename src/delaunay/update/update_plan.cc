#include "src/delaunay/update/update_plan.h"

#include <algorithm>
#include <atomic>
#include <mutex>
#include <string>
#include <utility>

#include "src/base/flat_codec.h"
#include "src/base/on_threads.h"
#include "src/tiling/tile/known_from_start.h"

namespace tessera {
namespace {

// Sorts out which of the points to be removed are duplicates. Returns those that must be vertices.
Result<PointIds> remove_duplicates(const TileSource& source, const PointIds& wanted, UpdatePlan& plan) {
  const Manifest& manifest = source.manifest();
  PointIds vertices = wanted;
  if (manifest.duplicates_xxh3 == 0) return vertices;
  BOOST_OUTCOME_TRY(pairs, read_duplicates(source.folder(), manifest.keep));
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
      plan.removed.insert(ids.begin(), ids.end());
      plan.losing.insert(source.entry(i).tile);
      lost[source.entry(i).tile] = ids.size();
    }
    return success();
  }));
  if (plan.removed.size() == vertices.size()) return lost;
  std::optional<PointId> least;
  for (const PointId id : vertices) {
    if (!plan.removed.contains(id) && (!least || id < *least)) least = id;
  }
  return error(Errc::usage, source.folder().string() + ": there is no point " + to_string(*least) +
                                " to remove: no vertex and no duplicate of this result has this source index");
}

// Any old point that stays will do. It is taken from the smallest tile that has one, as that is read fastest. A new
// point is taken only when no old point stays.
Status choose_common(const TileSource& source, const std::map<TileId, std::uint64_t>& lost, UpdatePlan& plan) {
  std::optional<std::size_t> smallest, any_heir;
  for (std::size_t i = 0; i < source.tiles(); ++i) {
    const TileEntry& entry = source.entry(i);
    const auto losing = lost.find(entry.tile);
    if (losing != lost.end() && !plan.heirs.empty()) any_heir = i;
    if (losing != lost.end() && losing->second == entry.own_points) continue;
    if (!smallest || entry.own_points < source.entry(*smallest).own_points) smallest = i;
  }
  if (smallest) {
    BOOST_OUTCOME_TRY(stored, source.read(*smallest, {.cells = false}));
    for (std::size_t v = 0; v < stored.mesh.ids.size() && !plan.common; ++v) {
      if (stored.mesh.point_ghost[v] == 0 && !plan.removed.contains(stored.mesh.ids[v]))
        plan.common = SharedPoint{stored.mesh.points[v], stored.mesh.ids[v], source.entry(*smallest).tile, 0};
    }
    return success();
  }
  for (std::size_t i = 0; i < source.tiles() && any_heir && !plan.common; ++i) {
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
  const PointIds wanted(change.remove.begin(), change.remove.end());
  plan.removed_points = wanted.size();
  std::map<TileId, std::uint64_t> lost;
  if (!wanted.empty()) {
    BOOST_OUTCOME_TRY(vertices, remove_duplicates(source, wanted, plan));
    BOOST_OUTCOME_TRY(found, find_vertices(source, vertices, threads, plan));
    lost = std::move(found);
  } else if (source.manifest().duplicates_xxh3 != 0) {
    BOOST_OUTCOME_TRY(pairs, read_duplicates(source.folder(), source.manifest().keep));
    plan.duplicates = std::move(pairs);
  }
  plan.first_new = source.manifest().points_read;
  for (std::size_t i = 0; i < change.add.size(); ++i) {
    const Point p = without_negative_zero(change.add[i]);
    plan.added[partition.tile_of(p)].push_back({p, PointId{plan.first_new + i}});
  }
  plan.rows = change.rows;
  BOOST_OUTCOME_TRYV(choose_common(source, lost, plan));
  return plan;
}

BigVector<std::byte> bytes_of(const UpdatePlan& plan) {
  FlatWriter out;
  std::vector<PointId> removed(plan.removed.begin(), plan.removed.end());
  std::sort(removed.begin(), removed.end());
  out.list(removed);
  out.list(std::vector<TileId>(plan.losing.begin(), plan.losing.end()));
  out.value(static_cast<std::uint64_t>(plan.added.size()));
  for (const auto& [tile, points] : plan.added) {
    out.value(tile);
    out.list(points);
  }
  std::vector<std::uint64_t> heirs;
  for (const auto& [vertex, heir] : plan.heirs) heirs.insert(heirs.end(), {vertex.value, heir.value});
  out.list(heirs);
  out.list(plan.duplicates);
  out.value(static_cast<std::uint8_t>(plan.duplicates_changed ? 1 : 0));
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
  std::uint8_t duplicates_changed = 0, has_common = 0;
  SharedPoint common;
  const bool read = in.list(heirs) && in.list(plan.duplicates) && in.value(duplicates_changed) &&
                    in.value(plan.first_new) && in.value(plan.removed_points) && in.list(plan.rows) &&
                    in.value(has_common) && in.value(common) && in.at_end();
  if (!read || heirs.size() % 2 != 0) return std::nullopt;
  for (std::size_t i = 0; i < heirs.size(); i += 2) plan.heirs[PointId{heirs[i]}] = PointId{heirs[i + 1]};
  plan.removed.reserve(removed.size());
  plan.removed.insert(removed.begin(), removed.end());
  plan.losing.insert(losing.begin(), losing.end());
  plan.duplicates_changed = duplicates_changed != 0;
  if (has_common != 0) plan.common = common;
  return plan;
}

}  // namespace tessera
