#include "src/delaunay/update/changed_tile.h"

#include <algorithm>
#include <utility>

#include "src/base/flat_codec.h"
#include "src/tiling/hilbert.h"
#include "src/tiling/routed_cloud.h"
#include "src/tiling/tile/changed_points.h"

namespace tessera {

BigVector<std::byte> bytes_of(const ToldOfHoles& told) {
  FlatWriter out;
  out.value(static_cast<std::uint8_t>(told.beside ? 1 : 0));
  out.list(told.around);
  out.list(told.filled);
  return out.take();
}

std::optional<ToldOfHoles> told_of(std::span<const std::byte> bytes) {
  FlatReader in(bytes);
  ToldOfHoles told;
  std::uint8_t beside = 0;
  if (!in.value(beside) || beside > 1 || !in.list(told.around) || !in.list(told.filled) || !in.at_end())
    return std::nullopt;
  told.beside = beside != 0;
  return told;
}

void put_in_hilbert_order(std::vector<SharedPoint>& points, int dimension) {
  Bounds bounds;
  for (const SharedPoint& p : points) bounds.add(p.at);
  const HilbertKey key(bounds, dimension);
  std::vector<std::pair<std::uint64_t, SharedPoint>> keyed;
  keyed.reserve(points.size());
  for (const SharedPoint& p : points) keyed.emplace_back(key(p.at), p);
  std::sort(keyed.begin(), keyed.end(), [](const auto& a, const auto& b) {
    return std::pair(a.first, a.second.id) < std::pair(b.first, b.second.id);
  });
  for (std::size_t i = 0; i < keyed.size(); ++i) points[i] = keyed[i].second;
}

StartOfTile start_of(TileId self, TileMesh stored, const UpdatePlan& plan, const ToldOfHoles& told) {
  StartOfTile start;
  const int dimension = stored.dimension;
  ChangedPoints changed = change_points(stored, self, plan.removed, {}, PointIds(told.filled));
  start.lost = changed.lost;
  start.reshaped = changed.reshaped;
  const std::size_t old = changed.own.size();
  for (std::size_t v = 0; start.lost && v < stored.ids.size(); ++v) {
    if (stored.owners[v] != self || !plan.removed.contains(stored.ids[v])) continue;
    // A point that takes the place of the vertex is a new point for the exchange, at the same coordinates.
    const auto heir = plan.heirs.find(stored.ids[v]);
    if (heir != plan.heirs.end()) {
      changed.own.push_back({stored.points[v], heir->second});
    } else {
      start.removed_bounds.add(stored.points[v]);
    }
  }
  stored = {};
  if (const auto added = plan.added.find(self); added != plan.added.end()) {
    changed.own.insert(changed.own.end(), added->second.begin(), added->second.end());
  }
  changed.fresh.resize(changed.own.size(), 1);
  start.foreign = std::move(changed.foreign);
  if (!told.around.empty()) {
    PointIds known;
    for (const SharedPoint& p : start.foreign) known.insert(p.id);
    for (const SharedPoint& p : told.around) {
      if (p.tile != self && known.insert(p.id)) start.foreign.push_back(p);
    }
  }
  put_in_hilbert_order(start.foreign, dimension);
  start.begins = changed.begins();
  if (!start.lost && changed.own.size() == old) {  // the order is still that of the bounds
    for (const LocalPoint& p : changed.own) {
      start.points.push_back(p.at);
      start.ids.push_back(p.id);
    }
    start.fresh = std::move(changed.fresh);
    return start;
  }
  PointIds fresh;  // few of the points are
  for (std::size_t i = 0; i < changed.own.size(); ++i) {
    if (changed.fresh[i] != 0) fresh.insert(changed.own[i].id);
  }
  LoadedTile ordered = order_points(changed.own, dimension);
  for (const auto& [duplicate, kept] : ordered.duplicates) start.duplicates.push_back({duplicate, kept});
  start.points = std::move(ordered.points);
  start.ids = std::move(ordered.ids);
  start.begins = false;
  for (const PointId id : start.ids) {
    start.fresh.push_back(fresh.contains(id) ? 1 : 0);
    start.begins |= start.fresh.back() != 0;
  }
  return start;
}

BigVector<std::byte> bytes_of(const TileEnd& end) {
  FlatWriter out;
  for (const bool flag : {end.begun, end.awake, end.lost, end.changed})
    out.value(static_cast<std::uint8_t>(flag ? 1 : 0));
  out.value(end.bounds);
  out.value(end.removed_bounds);
  out.value(end.counts);
  out.list(end.duplicates);
  out.list(end.entry ? bytes_of(*end.entry) : BigVector<std::byte>());
  return out.take();
}

std::optional<TileEnd> tile_end_of(std::span<const std::byte> bytes) {
  FlatReader in(bytes);
  TileEnd end;
  for (bool* flag : {&end.begun, &end.awake, &end.lost, &end.changed}) {
    std::uint8_t value = 0;
    if (!in.value(value) || value > 1) return std::nullopt;
    *flag = value != 0;
  }
  BigVector<std::byte> entry;
  const bool read = in.value(end.bounds) && in.value(end.removed_bounds) && in.value(end.counts) &&
                    in.list(end.duplicates) && in.list(entry) && in.at_end();
  if (!read) return std::nullopt;
  if (entry.empty()) return end;
  end.entry = tile_entry_of(entry);
  if (!end.entry) return std::nullopt;
  return end;
}

}  // namespace tessera
