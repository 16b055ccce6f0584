// What a tile tells others of points that have arrived: by the rule of docs/design.md, section 2, or by the published
// one.
#include <algorithm>
#include <utility>

#include "src/base/check.h"
#include "src/tiling/tile/tile_triangulation.h"

namespace tessera {

void TileTriangulation::introduce() {
  if (!std::exchange(seeded_, true)) {
    for (const Seed& seed : options_.around->seeds_of(options_.self)) {
      if (seed.point.tile != options_.self) add_seed(seed);
    }
    std::erase_if(refused_, [&](const Refused& r) {  // seeds are vertices, even if they were refused
      const Vertex v = foreign_.at(r.point.id);
      if (v != 0) record_received(v, r.from, r.point);
      return v != 0;
    });
  }
  if (kernel_->dimension() < options_.dimension) {
    share_with_all();
  } else {
    introduce_vertices();
  }
  // Refused points are not kept, but the vertices that would be their neighbours, all foreign, are introduced to them.
  for (const Refused& r : refused_) {
    stop_check_.step();
    const Insertion again = kernel_->insert(r.point.at, false, InsertMode::if_local_neighbour, around_);
    check_read(!again.inserted, "what conflicts with no local star never will");
    for (const Vertex w : around_) {
      if (!is_known_by(r.point.tile, w) && !rely_on_told_bit_of_refused(owners_[w], r) &&
          !rely_on_told_bit(r.point.tile, w))
        send(w, r.point.tile);
    }
  }
  refused_.clear();
  due_ = kernel_->vertices() + 1;
}

// If new vertices are not few, one pass over the cells costs a fraction of a walk around each new vertex.
void TileTriangulation::introduce_vertices() {
  if ((kernel_->vertices() + 1 - due_) > kernel_->vertices() / 16) {
    kernel_->edges_from(due_, [&](Vertex v, Vertex w) {
      stop_check_.step();
      introduce(v, w);
    });
    return;
  }
  for (Vertex v = due_; v <= kernel_->vertices(); ++v) {
    stop_check_.step();
    kernel_->neighbours(v, around_);
    for (const Vertex w : around_) introduce(v, w);
  }
}

// For two foreign points it is enough that one of the owners hears of the other's point.
void TileTriangulation::introduce(Vertex v, Vertex neighbour) {
  const TileId owner = owners_[v], other = owners_[neighbour];
  if (is_local(neighbour)) return send(neighbour, owner);
  if (is_known_by(owner, neighbour) || is_known_by(other, v) || rely_on_told_bit(owner, neighbour) ||
      rely_on_told_bit(other, v))
    return;
  // A seed is a neighbour of many points. Telling one owner of the seed spares telling the seed's owner of all of them.
  if (seeds_.contains(v)) return send(v, other);
  send(neighbour, owner);
}

bool TileTriangulation::is_known_by(TileId tile, Vertex v) const {
  return owners_[v] == tile || sent_.has(v, tile) || has_as_seed(tile, v);
}

// Whether some tile has told `tile` of v. From now on the pair counts as sent by this tile, too, so that it is sent
// again after a restart or a loss.
bool TileTriangulation::rely_on_told_bit(TileId tile, Vertex v) {
  if (told_[v] == 0 || (told_[v] & options_.around->bit(owners_[v], tile)) == 0) return false;
  if (sent_.add(v, tile)) relied_.push_back(std::uint64_t{v} << 32 | tile.value);
  return true;
}

// Whether `tile` has been told of a refused point. That point is no vertex, so it cannot be in the sent-set.
bool TileTriangulation::rely_on_told_bit_of_refused(TileId tile, const Refused& refused) {
  const SharedPoint& p = refused.point;
  const bool itself = tile == refused.from;
  if (!itself && (p.told & options_.around->bit(p.tile, tile)) == 0) return false;
  for (auto r = refused_relied_.rbegin(); r != refused_relied_.rend() && r->point.id == p.id; ++r) {
    if (r->tile == tile) return true;  // noted before, for another neighbour
  }
  refused_relied_.push_back({{p.at, p.id, p.tile, 0}, tile, itself ? 0u : 1u});
  return true;
}

// Notes that `tile` knows v. Returns false if that had been noted before.
bool TileTriangulation::record_sent(Vertex v, TileId tile) {
  if (!sent_.add(v, tile)) return false;
  told_[v] |= options_.around->bit(owners_[v], tile);
  return true;
}

// Notes what a message says of a vertex: the sender knows it, and the told bits.
void TileTriangulation::record_received(Vertex v, TileId from, const SharedPoint& p) {
  record_sent(v, from);
  told_[v] |= p.told;
}

// Whether `tile` knows v from the start.
bool TileTriangulation::has_as_seed(TileId tile, Vertex v) const {
  const auto seed = seeds_.find(v);
  if (seed == seeds_.end()) return false;
  return options_.around->has(tile, {{kernel_->point(v), ids_[v], owners_[v], 0}, seed->second});
}

// While the tile is flat every vertex counts as a neighbour of every other, because ties are not broken yet.
void TileTriangulation::share_with_all() {
  for (Vertex v = 1; v <= kernel_->vertices(); ++v) {
    if (is_local(v)) continue;
    for (Vertex w = 1; w <= kernel_->vertices(); ++w) {
      if (w != v) send(w, owners_[v]);
    }
  }
}

void TileTriangulation::send(Vertex v, TileId tile) {
  if (tile == options_.self || owners_[v] == tile || sent_.has(v, tile) || has_as_seed(tile, v)) return;
  record_sent(v, tile);
  updates_[tile].push_back(v);
  ++counts_.sent;
}

std::map<TileId, std::vector<SharedPoint>> TileTriangulation::take_updates() {
  std::map<TileId, std::vector<SharedPoint>> out;
  for (const auto& [tile, list] : std::exchange(updates_, {})) {
    auto& points = out[tile];
    points.reserve(list.size());
    for (const Vertex v : list) points.push_back(shared(v));
  }
  for (auto& [tile, list] : std::exchange(refused_updates_, {})) {
    auto& points = out[tile];
    points.insert(points.end(), list.begin(), list.end());
  }
  return out;
}

// The published order: insert everything, simplify, then splay the points that are left.
Status TileTriangulation::receive_published(TileId from, std::span<const SharedPoint> points) {
  std::vector<Vertex> around, added;
  for (const SharedPoint& p : points) {
    ++counts_.received;
    if (const auto known = foreign_.find(p.id); known != foreign_.end() && known->second != 0) continue;
    BOOST_OUTCOME_TRY(v, add_foreign(p, true, around));
    added.push_back(v);
    sent_.add(v, from);
  }
  for (Vertex v = 1; v <= kernel_->vertices(); ++v) {
    if (is_local(v) || !kernel_->alive(v) || kernel_->dimension() < options_.dimension) continue;
    kernel_->neighbours(v, around);
    if (std::none_of(around.begin(), around.end(), [&](Vertex w) { return is_local(w); })) {
      kernel_->remove(v);
      foreign_[ids_[v]] = 0;
    }
  }
  if (kernel_->dimension() < options_.dimension) {
    share_with_all();
    return success();
  }
  for (const Vertex v : added) {
    if (!kernel_->alive(v)) continue;
    kernel_->neighbours(v, around);
    for (const Vertex w : around) {
      send(w, owners_[v]);
      send(v, owners_[w]);
    }
  }
  return success();
}

}  // namespace tessera
