#include "src/delaunay/update/woken_tile.h"

#include <algorithm>

#include "src/tiling/hilbert.h"
#include "src/tiling/routed_cloud.h"

namespace tessera {
namespace {

// So that each is inserted near the one before.
void put_in_hilbert_order(std::vector<SharedPoint>& points, int dimension) {
  Bounds bounds;
  for (const SharedPoint& p : points) bounds.add(p.at);
  const HilbertKey key(bounds, dimension);
  std::sort(points.begin(), points.end(), [&](const SharedPoint& a, const SharedPoint& b) {
    return std::pair(key(a.at), a.id) < std::pair(key(b.at), b.id);
  });
}

std::set<TileId> owners_beside(const TileMesh& mesh, const PointIds& removed) {
  std::set<TileId> owners;
  std::vector<std::uint8_t> gone(mesh.ids.size());
  for (std::size_t v = 0; v < gone.size(); ++v) gone[v] = removed.contains(mesh.ids[v]) ? 1 : 0;
  const auto corners = static_cast<std::size_t>(mesh.dimension) + 1;
  for (std::size_t at = 0; at < mesh.cells.size(); at += corners) {
    const std::int32_t* cell = &mesh.cells[at];
    if (std::none_of(cell, cell + corners, [&](std::int32_t v) { return gone[v] != 0; })) continue;
    for (std::size_t i = 0; i < corners; ++i) owners.insert(mesh.owners[cell[i]]);
  }
  return owners;
}

}  // namespace

Status WokenTile::read() {
  const Manifest& manifest = setting_.source.manifest();
  StoredTile stored;
  stored.mesh.dimension = manifest.dimension;
  if (const auto index = setting_.source.find(self_)) {
    BOOST_OUTCOME_TRY(tile, setting_.source.read(*index, {.cells = true, .rows = !manifest.schema.empty()}));
    stored = std::move(tile);
  }
  const TileMesh& mesh = stored.mesh;
  if (setting_.plan.losing.contains(self_)) beside_removed_ = owners_beside(mesh, setting_.plan.removed);
  ChangedPoints changed = change_points(mesh, self_, setting_.plan.removed, {});
  lost_ = changed.lost;
  foreign_ = std::move(changed.foreign);
  put_in_hilbert_order(foreign_, manifest.dimension);
  for (std::size_t i = 0; i < changed.own.size(); ++i) old_[changed.own[i].id] = changed.fresh[i];
  std::vector<LocalPoint> own = std::move(changed.own);
  if (!own.empty()) old_point_ = SharedPoint{own[0].at, own[0].id, self_, 0};
  for (std::size_t v = 0; lost_ && v < mesh.ids.size(); ++v) {
    if (mesh.owners[v] != self_ || !setting_.plan.removed.contains(mesh.ids[v])) continue;
    // A point that takes the place of the vertex is a new point for the exchange, at the same coordinates.
    const auto heir = setting_.plan.heirs.find(mesh.ids[v]);
    if (heir != setting_.plan.heirs.end()) {
      own.push_back({mesh.points[v], heir->second});
    } else {
      removed_bounds_.add(mesh.points[v]);
    }
  }
  if (const auto added = setting_.plan.added.find(self_); added != setting_.plan.added.end()) {
    own.insert(own.end(), added->second.begin(), added->second.end());
  }
  LoadedTile ordered = order_points(own, manifest.dimension);
  for (const auto& [duplicate, kept] : ordered.duplicates) duplicates_.push_back({duplicate, kept});
  points_ = std::move(ordered.points);
  ids_ = std::move(ordered.ids);
  for (const PointId id : ids_) {
    const auto known = old_.find(id);
    fresh_.push_back(known == old_.end() ? 1 : known->second);
    begins_ |= fresh_.back() != 0;
  }
  rows_ = std::move(stored.rows);
  for (std::size_t v = 0; !rows_.empty() && v < mesh.ids.size(); ++v) row_of_[mesh.ids[v]] = v;
  return success();
}

std::vector<SharedPoint> WokenTile::affected(std::size_t most) const {
  std::vector<std::size_t> all;
  for (std::size_t i = 0; i < ids_.size(); ++i) {
    if (fresh_[i] != 0 && old_.contains(ids_[i])) all.push_back(i);
  }
  const std::size_t stride = (all.size() + most - 1) / most;
  std::vector<SharedPoint> out;
  for (std::size_t k = 0; k < all.size(); k += stride) out.push_back({points_[all[k]], ids_[all[k]], self_, 0});
  return out;
}

void WokenTile::know(const std::vector<SharedPoint>& points) {
  PointIds known;
  for (const SharedPoint& p : foreign_) known.insert(p.id);
  for (const SharedPoint& p : points) {
    if (p.tile != self_ && known.insert(p.id).second) foreign_.push_back(p);
  }
  put_in_hilbert_order(foreign_, setting_.source.manifest().dimension);
}

Status WokenTile::begin(const std::optional<SharedPoint>& common) {
  triangulation_ = std::make_unique<TileTriangulation>(TileOptions{.self = self_,
                                                                   .dimension = setting_.source.manifest().dimension,
                                                                   .around = &setting_.around,
                                                                   .stop = setting_.stop});
  BOOST_OUTCOME_TRYV(triangulation_->triangulate_changed(
      {points_, ids_, fresh_, foreign_, begins_ ? common : std::nullopt}, KeepPoints::borrowed));
  std::vector<SharedPoint>().swap(foreign_);
  return success();
}

Status WokenTile::step(const Mail& mail) {
  for (const auto& [from, points] : mail) {
    BOOST_OUTCOME_TRYV(triangulation_->receive(from, points));
  }
  triangulation_->introduce();
  counts_ = triangulation_->counts();
  return success();
}

TileMesh WokenTile::collect() {
  TileMesh mesh = triangulation_->collect(std::move(points_), std::move(ids_), {}).whole();
  counts_ = triangulation_->counts();
  triangulation_.reset();
  return mesh;
}

std::optional<std::span<const std::byte>> WokenTile::row(PointId id) const {
  const std::size_t width = row_bytes(setting_.source.manifest().schema);
  if (id.value >= setting_.plan.first_new) {
    return setting_.rows.subspan((id.value - setting_.plan.first_new) * width, width);
  }
  const auto found = row_of_.find(id);
  if (found == row_of_.end()) return setting_.plan.old.row(id);  // a duplicate that has become a vertex
  return std::span(rows_).subspan(found->second * width, width);
}

}  // namespace tessera
