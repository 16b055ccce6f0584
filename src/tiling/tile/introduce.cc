// What a tile tells others: before the first splay, of points that have arrived (by the rule of docs/design.md, section
// 2, or by the published one), and what it sends again after a loss (docs/recovery.md).
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "src/base/check.h"
#include "src/base/image.h"
#include "src/tiling/tile/circumsphere.h"
#include "src/tiling/tile/spacing.h"
#include "src/tiling/tile/tile_triangulation.h"

namespace tessera {
namespace {

// How far a sphere must reach into a neighbour's bounds before its vertices are announced, in radii of the sphere:
// where spheres are small, points are dense.
constexpr double announce_depth = 0.6;

double longest_edge(std::span<const Point> corners) {
  double squared = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      const double x = corners[i].x - corners[k].x, y = corners[i].y - corners[k].y, z = corners[i].z - corners[k].z;
      squared = std::max(squared, x * x + y * y + z * z);
    }
  }
  return std::sqrt(squared);
}

// Whether the sphere reaches well into the bounds. A sphere that only just reaches a neighbour's points has most likely
// none of them inside.
bool reaches_well(const Ball& ball, const Bounds& bounds, int dimension) {
  if (bounds.empty()) return false;
  const double most = ball.radius * ball.radius;
  double squared = 0;
  for (int i = 0; i < dimension; ++i) {
    const double depth = std::min(announce_depth * ball.radius, (bounds.hi[i] - bounds.lo[i]) / 4);
    const double gap = std::max({bounds.lo[i] + depth - ball.center[i], ball.center[i] + depth - bounds.hi[i], 0.0});
    squared += gap * gap;
    if (squared > most) return false;
  }
  return true;
}

}  // namespace

void TileTriangulation::announce(std::span<const Point> points, const Box& box) {
  const auto neighbours = options_.around->neighbours(options_.self);
  if (neighbours.empty() || kernel_->dimension() < options_.dimension) return;
  const int d = options_.dimension, corners = d + 1;
  const auto at = [&](Vertex v) {
    if (!is_local(v)) return kernel_->point(v);
    return points[reduced_ ? ranks_[v] : v - 1];
  };
  // Slivers at the hull have huge spheres, which will not be empty when the neighbours' points arrive. Announcing their
  // vertices would double the points that are sent and refused (3 M terrain points: 743 k sent against 218 k).
  Bounds bounds;
  for (const Point& q : points) bounds.add(q);
  // Only cells with a vertex near a face of the box are announced. Most slivers have none: the top of a terrain is
  // covered by slivers.
  const double near = 4 * even_spacing(bounds, points.size(), d);
  const auto near_face = [&](Vertex v) {
    const Point q = at(v);
    for (int i = 0; i < d; ++i) {
      if (std::min(q[i] - box.lo[i], box.hi[i] - q[i]) < near) return true;
    }
    return false;
  };
  const std::vector<Vertex> cells = kernel_->explore([&](const Vertex* cell) {
    if (std::none_of(cell, cell + corners, near_face)) return true;
    if (!handed_out_) return surely_final(cell, points, box);
    return !kernel_->can_freeze() && !open_cells_.contains(cell_key(cell, d));
  });
  std::array<Point, 4> p;
  for (std::size_t c = 0; c < cells.size(); c += corners) {
    const Vertex* v = &cells[c];
    if (std::find(v, v + corners, infinite_vertex) != v + corners) continue;
    if (std::none_of(v, v + corners, [&](Vertex w) { return is_local(w); })) continue;
    for (int i = 0; i < corners; ++i) p[i] = at(v[i]);
    const Ball ball = d == 3 ? circumsphere(p[0], p[1], p[2], p[3]) : circumcircle(p[0], p[1], p[2]);
    if (!ball.known || ball.radius > longest_edge(std::span(p).first(corners))) continue;
    for (const TileId n : neighbours) {
      if (!reaches_well(ball, options_.around->bounds(n), d)) continue;
      for (int i = 0; i < corners; ++i) {
        if (tessera::near(ids_[v[i]], n)) send(v[i], n);
      }
    }
  }
  tell_self();
}

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
  introduce_once();
  if (!options_.around->periodic()) return;
  for (tell_self(); due(); tell_self()) introduce_once();
}

void TileTriangulation::introduce_once() {
  const bool periodic = options_.around->periodic();
  if (kernel_->dimension() < options_.dimension) {
    check_read(!periodic, "the seeds of a periodic cloud span space");
    share_with_all();
  } else {
    if (periodic) shorten_edges();
    introduce_vertices();
    if (fresh_) introduce_due();
  }
  due_ = kernel_->vertices() + 1;
  std::erase_if(refused_, [&](const Refused& r) { return introduce_refused(r); });
}

// Refused points are not kept, but the vertices that would be their neighbours, all foreign, are introduced to them.
// Returns false when there are new vertices because one of these edges was long: once more, then.
bool TileTriangulation::introduce_refused(const Refused& r) {
  stop_check_.step();
  if (options_.around->periodic() && foreign_.at(r.point.id) != 0) return true;  // a vertex since then
  const Insertion again = kernel_->insert(r.point.at, false, InsertMode::if_local_neighbour, around_);
  check_read(!again.inserted, "a point that was in conflict with no local star never will be");
  if (options_.around->periodic()) {
    for (const Vertex w : around_) {
      if (!near(r.point.id, ids_[w])) return shorten(r.point, shared(w)), false;
    }
  }
  const bool fresh = !fresh_ || fresh_->has_refused(r.point.id);
  if (fresh && options_.left_out == LeftOut::refused_fresh) return true;
  for (const Vertex w : around_) {
    if (!fresh && !fresh_->has(w)) continue;
    if (is_known_by(r.point.tile, w) || known_.rely_on_told_bit_of_refused(r.point, r.from, owners_[w]) ||
        known_.rely_on_told_bit(w, owners_[w], r.point.tile))
      continue;
    if (!fresh) {
      quote_refused(r.point, owners_[w]);
    } else if (is_fresh(w)) {
      send(w, r.point.tile);
    } else {
      quote(w, r.point.tile);
    }
  }
  return true;
}

// A refused point that is not fresh is quoted to the owner of a fresh point beside it. To tell the owner of the refused
// point of the fresh one would be right, too, but that tile may sleep: where points were removed at the hull, tile
// after tile woke in this way.
void TileTriangulation::quote_refused(const SharedPoint& p, TileId tile) {
  if (!fresh_->add_refused_quote(p, tile)) return;
  refused_updates_[tile].push_back({p.at, p.id, p.tile, 0});
  ++counts_.sent;
}

// Visits the edges of vertices that have not been introduced. If these are not few, one pass over the cells costs a
// fraction of a walk around each of them.
template <class Visit>
void TileTriangulation::edges_due(const Visit& visit) {
  if ((kernel_->vertices() + 1 - due_) > kernel_->vertices() / 16) {
    kernel_->edges_from(due_, [&](Vertex v, Vertex w) {
      stop_check_.step();
      visit(v, w);
    });
    return;
  }
  for (Vertex v = due_; v <= kernel_->vertices(); ++v) {
    stop_check_.step();
    kernel_->neighbours(v, around_);
    for (const Vertex w : around_) visit(v, w);
  }
}

void TileTriangulation::introduce_vertices() {
  edges_due([&](Vertex v, Vertex w) { introduce(v, w); });
}

// Inserts images until no edge is long, so that a tile never hears of an image that is not near
// (docs/periodic-design.md).
void TileTriangulation::shorten_edges() {
  std::vector<std::pair<Vertex, Vertex>> edges;
  do {
    edges.clear();
    edges_due([&](Vertex v, Vertex w) {
      if (!near(ids_[v], ids_[w])) edges.emplace_back(v, w);
    });
    for (const auto& [v, w] : edges) shorten(shared(v), shared(w));
  } while (!edges.empty());
}

// An edge between two points is long when their offsets along an axis differ by two. When the image of each point that
// is a period nearer to the other is in the triangulation, the edge is not.
void TileTriangulation::shorten(const SharedPoint& p, const SharedPoint& q) {
  const PeriodOffset apart = offset_of(q.id) - offset_of(p.id);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (apart.by[axis] != 2 && apart.by[axis] != -2) continue;
    PeriodOffset nearer;
    nearer.by[axis] = apart.by[axis] / 2;
    add_image(p, nearer);
    add_image(q, PeriodOffset{} - nearer);
  }
}

// Inserts the image that lies `by` periods from a point, unless the tile has it.
void TileTriangulation::add_image(const SharedPoint& p, const PeriodOffset& by) {
  const PeriodOffset o = offset_of(p.id) + by;
  const SharedPoint there{options_.around->period().shifted(p.at, by), image_of(p.id, o), image_of(p.tile, o), 0};
  if (there.tile == options_.self) return;
  if (const auto known = foreign_.find(there.id); known != foreign_.end() && known->second != 0) return;
  std::vector<Vertex> around;
  const auto added = add_foreign(there, true, around);
  check_read(added.has_value(), "an image of a point has the coordinates of another point");
}

// Vertices that have become fresh after their edges were made.
void TileTriangulation::introduce_due() {
  for (const Vertex v : fresh_->take_due()) {
    stop_check_.step();
    kernel_->neighbours(v, around_);
    for (const Vertex w : around_) {
      if (!is_local(v)) {
        introduce(v, w);
      } else if (!is_local(w)) {
        send(v, owners_[w]);
      }
    }
  }
}

// For two foreign points it is enough that one of the owners hears of the other's point. If only one of the two is
// fresh, its owner hears of the other one: so a tile that sleeps is not woken.
void TileTriangulation::introduce(Vertex v, Vertex neighbour) {
  const TileId owner = owners_[v], other = owners_[neighbour];
  if (fresh_ && !fresh_->has(v) && (!fresh_->has(neighbour) || options_.left_out == LeftOut::old_arrivals)) return;
  if (is_local(neighbour)) return send(neighbour, owner);
  if (options_.left_out == LeftOut::foreign_pairs) return;
  if (is_known_by(owner, neighbour) || is_known_by(other, v) || known_.rely_on_told_bit(neighbour, other, owner) ||
      known_.rely_on_told_bit(v, owner, other))
    return;
  if (!is_fresh(neighbour)) return quote(neighbour, owner);
  if (!is_fresh(v)) return quote(v, other);
  // A seed is a neighbour of many points. Telling one owner of the seed spares telling the seed's owner of all of them.
  if (seeds_.contains(v)) return send(v, other);
  send(neighbour, owner);
}

bool TileTriangulation::is_known_by(TileId tile, Vertex v) const {
  return owners_[v] == tile || known_.has(v, tile) || has_as_seed(tile, v);
}

// Whether `tile` knows v from the start.
bool TileTriangulation::has_as_seed(TileId tile, Vertex v) const {
  const auto seed = seeds_.find(v);
  if (seed == seeds_.end()) return false;
  return options_.around->has(tile, {{kernel_->point(v), ids_[v], owners_[v], 0}, seed->second});
}

// Tells a tile of a vertex that this tile does not know to be fresh. Neither of the two notes that, as it says nothing
// of what the tiles know of the vertex's surroundings.
void TileTriangulation::quote(Vertex v, TileId tile) {
  if (tile == options_.self || is_known_by(tile, v) || !fresh_->add_quote(v, tile)) return;
  updates_[tile].push_back(v);
  ++counts_.sent;
}

// While the tile is flat every vertex counts as a neighbour of every other, because ties are not broken yet. All
// vertices count as fresh, too.
void TileTriangulation::share_with_all() {
  if (fresh_) fresh_->learn_all();
  for (Vertex v = 1; v <= kernel_->vertices(); ++v) {
    if (is_local(v) || !kernel_->alive(v)) continue;
    for (Vertex w = 1; w <= kernel_->vertices(); ++w) {
      if (w != v && kernel_->alive(w)) send(w, owners_[v]);
    }
  }
}

void TileTriangulation::send(Vertex v, TileId tile) {
  if (tile == options_.self || is_known_by(tile, v)) return;
  known_.record_sent(v, owners_[v], tile);
  updates_[tile].push_back(v);
  ++counts_.sent;
}

std::map<TileId, std::vector<SharedPoint>> TileTriangulation::take_updates() {
  std::map<TileId, std::vector<SharedPoint>> out;
  for (const auto& [tile, list] : std::exchange(updates_, {})) {
    auto& points = out[plain(tile)];
    points.reserve(points.size() + list.size());
    for (const Vertex v : list) points.push_back(seen_from(tile, shared(v)));
  }
  for (auto& [tile, list] : std::exchange(refused_updates_, {})) {
    auto& points = out[plain(tile)];
    for (const SharedPoint& p : list) points.push_back(seen_from(tile, p));
  }
  return out;
}

// An image of a tile is told what the tile itself would be told if all were shifted.
SharedPoint TileTriangulation::seen_from(TileId tile, const SharedPoint& p) const {
  if (offset_code(tile) == 0) return p;
  const PeriodOffset back = PeriodOffset{} - offset_of(tile), o = offset_of(p.id) + back;
  check(o.near(), "only points that are near are told");
  return {options_.around->period().shifted(p.at, back), image_of(p.id, o), image_of(p.tile, o), p.told};
}

// The tile is its own neighbour: what it has to tell an image of itself it takes in at once. So nothing of that is
// under way when the tile is saved, and no other tile has to repeat it. Points that have come this way are never
// refused, because refused points would not be saved before they are introduced.
void TileTriangulation::tell_self() {
  if (!options_.around->periodic()) return;
  std::vector<SharedPoint> told;
  const auto take = [&](auto& updates, const auto& point_of) {
    for (auto at = updates.begin(); at != updates.end();) {
      if (plain(at->first) != options_.self) {
        ++at;
        continue;
      }
      for (const auto& point : at->second) told.push_back(seen_from(at->first, point_of(point)));
      at = updates.erase(at);
    }
  };
  take(updates_, [&](Vertex v) { return shared(v); });
  take(refused_updates_, [](const SharedPoint& p) { return p; });
  for (const SharedPoint& p : told) {
    stop_check_.step();
    ++counts_.received;
    if (p.tile == options_.self || foreign_.contains(p.id)) continue;
    const auto added = add_foreign(p, true, around_);
    check_read(added.has_value(), "an image of a point has the coordinates of another point");
  }
}

// The published order: insert everything, simplify, then splay the points that are left.
Status TileTriangulation::receive_published(TileId from, std::span<const SharedPoint> points) {
  std::vector<Vertex> around, added;
  for (const SharedPoint& p : points) {
    ++counts_.received;
    if (const auto known = foreign_.find(p.id); known != foreign_.end() && known->second != 0) continue;
    BOOST_OUTCOME_TRY(v, add_foreign(p, true, around));
    added.push_back(v);
    known_.record_published(v, from);
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

void TileTriangulation::replay() {
  replay_if([](TileId) { return true; });
}

void TileTriangulation::replay_to(std::span<const TileId> reborn) {
  replay_if([&](TileId tile) { return std::binary_search(reborn.begin(), reborn.end(), tile); });
}

void TileTriangulation::replay_if(const std::function<bool(TileId)>& reborn) {
  const auto tell = [&](Vertex v, TileId tile) {
    updates_[tile].push_back(v);
    ++counts_.sent;
  };
  const auto tell_refused = [&](const SharedPoint& point, TileId tile) {
    SharedPoint p = point;
    if (fresh_ && fresh_->has_refused(p.id)) p.told |= fresh_bit;
    refused_updates_[tile].push_back(p);
    ++counts_.sent;
  };
  known_.replay(
      owners_, [&](TileId tile) { return reborn(plain(tile)); }, tell, tell_refused);
  if (fresh_ && options_.left_out != LeftOut::replayed_quotes) fresh_->replay(reborn, tell, tell_refused);
  tell_self();
}

}  // namespace tessera
