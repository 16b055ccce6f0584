#include "src/tiling/tile/tile_triangulation.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "src/base/check.h"
#include "src/tiling/tile/circumsphere.h"
#include "src/tiling/tile/collect.h"
#include "src/tiling/tile/spacing.h"

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
  const double most = ball.reach * ball.reach;
  double squared = 0;
  for (int i = 0; i < dimension; ++i) {
    const double depth = std::min(announce_depth * ball.reach, (bounds.hi[i] - bounds.lo[i]) / 4);
    const double gap = std::max({bounds.lo[i] + depth - ball.center[i], ball.center[i] + depth - bounds.hi[i], 0.0});
    squared += gap * gap;
    if (squared > most) return false;
  }
  return true;
}

}  // namespace

TileTriangulation::TileTriangulation(const TileOptions& options)
    : options_(options), kernel_(make_kernel(options.dimension, options.kernel)) {}

void TileTriangulation::triangulate(std::span<const Point> points, std::span<const PointId> ids, KeepPoints keep) {
  check(points.size() == ids.size(), "every point has an id");
  kernel_->build(points, keep, options_.stop);
  ids_.assign(1, PointId{});
  ids_.insert(ids_.end(), ids.begin(), ids.end());
  owners_.assign(points.size() + 1, options_.self);
  told_.assign(points.size() + 1, 0);
  due_ = static_cast<Vertex>(ids_.size());
  for (const Seed& seed : options_.around->seeds_of(options_.self)) {
    if (seed.point.tile == options_.self) {
      const auto own = std::find(ids.begin(), ids.end(), seed.point.id);
      check_read(own != ids.end(), "a seed is no point of the tile that owns it");
      seeds_[static_cast<Vertex>(own - ids.begin() + 1)] = seed.reach;
    } else if (kernel_->dimension() < options_.dimension) {
      add_seed(seed);
    }
  }
}

// Also inserts a seed that was refused when a message brought it: no tile sends seeds, so images must have them.
void TileTriangulation::add_seed(const Seed& seed) {
  const auto known = foreign_.find(seed.point.id);
  Vertex v = known == foreign_.end() ? 0 : known->second;
  if (v == 0) {
    const auto added = add_foreign(seed.point, true, around_);
    check_read(added.has_value(), "a seed is a point that the tile knows under another number");
    v = added.value();
  }
  seeds_[v] = seed.reach;
}

bool TileTriangulation::surely_final(const Vertex* cell, std::span<const Point> points, const Box& box) const {
  const auto at = [&](int i) -> const Point& { return points[cell[i] - 1]; };
  const Ball ball =
      options_.dimension == 3 ? circumsphere(at(0), at(1), at(2), at(3)) : circumcircle(at(0), at(1), at(2));
  return surely_inside(ball, box, options_.dimension);
}

// Why exploring from the outside finds every cell that is not final: let a foreign point q be in conflict with cell c.
// The cells in conflict with q are connected. q lies outside the box, so outside the hull of the local points. So one
// of these cells has an infinite or foreign vertex. None of these cells has its circumsphere inside the box, so the
// path to c is followed.
FinalCells TileTriangulation::reduce(std::span<const Point> points, const Box& box, bool quick) {
  check(!handed_out_ && updates_.empty(), "a tile is reduced once, before it announces");
  if (kernel_->dimension() < options_.dimension) return {};
  throw_if_stopped(options_.stop);
  const auto is_final = [&](const Vertex* cell) {
    stop_check_.step();
    return surely_final(cell, points, box);
  };
  if (!kernel_->can_freeze()) return build_reduced(points, is_final);
  FinalCells finals = kernel_->freeze(is_final);
  handed_out_ = true;
  if (!quick) forget_vertices(points.size());
  return finals;
}

// Loads the cells that are left into a kernel that knows only their vertices.
void TileTriangulation::forget_vertices(std::size_t own) {
  KernelImage image = kernel_->save();
  kernel_.reset();
  const std::vector<Vertex> to = renumber(image.cells.vertices, own);
  for (Vertex& v : image.cells.vertices) v = to[v];
  for (Vertex v = 1; v < to.size(); ++v) {  // numbers only decrease
    if (to[v] == 0) continue;
    image.points[to[v] - 1] = image.points[v - 1];
    image.local[to[v] - 1] = image.local[v - 1];
    image.alive[to[v] - 1] = image.alive[v - 1];
  }
  image.points.resize(ids_.size() - 1);
  image.local.resize(ids_.size() - 1);
  image.alive.resize(ids_.size() - 1);
  kernel_ = make_kernel(options_.dimension, options_.kernel);
  check(kernel_->load(image), "a kernel loads what it saved");
}

// For a kernel that cannot freeze cells: triangulates the vertices of the other cells again (Caraffa et al., section
// 2.3).
FinalCells TileTriangulation::build_reduced(std::span<const Point> points,
                                            const std::function<bool(const Vertex*)>& is_final) {
  const int corners = options_.dimension + 1;
  CellList list;
  std::vector<std::uint8_t> open;
  const std::vector<Vertex> open_cells = kernel_->explore(is_final, &list, &open);
  if (open_cells.size() == list.vertices.size()) return {};
  const Vertex before = kernel_->vertices();
  std::vector<Point> foreign;
  for (Vertex v = static_cast<Vertex>(points.size() + 1); v <= before; ++v) foreign.push_back(kernel_->point(v));
  kernel_.reset();  // frees nine tenths of the tile's memory before more is needed
  const std::vector<Vertex> to = renumber(open_cells, points.size());
  std::vector<Point> kept;
  for (Vertex v = 1; v < ids_.size() && is_local(v); ++v) kept.push_back(points[ranks_[v]]);
  kernel_ = make_kernel(options_.dimension, options_.kernel);
  kernel_->build(kept, KeepPoints::copied, options_.stop);
  std::vector<Vertex> around;
  for (const Point& p : foreign) kernel_->insert(p, false, InsertMode::always, around);
  std::array<Vertex, 4> cell{};
  for (std::size_t c = 0; c < open_cells.size(); c += corners) {
    bool all_local = true;
    for (int i = 0; i < corners; ++i) {
      cell[i] = to[open_cells[c + i]];
      all_local &= is_local(cell[i]);
    }
    if (all_local) open_cells_.insert(cell_key(cell.data(), options_.dimension));
  }
  return extract_final(list, open, options_.dimension);
}

// Keeps the tile's own vertices that are in `used`, in the old order, which is Hilbert order, and all foreign vertices:
// they are vertices of infinite or mixed cells, which are never final. Returns the new number of each vertex, or 0.
std::vector<Vertex> TileTriangulation::renumber(std::span<const Vertex> used, std::size_t own) {
  std::vector<Vertex> to(ids_.size(), 0);
  for (const Vertex v : used) to[v] = 1;
  to[infinite_vertex] = 0;
  std::vector<PointId> ids(1);
  std::vector<TileId> owners(1, options_.self);
  ranks_.assign(1, 0);
  for (Vertex v = 1; v < to.size(); ++v) {
    const bool local = v <= own;
    if (local && to[v] == 0) continue;
    to[v] = static_cast<Vertex>(ids.size());
    ids.push_back(ids_[v]);
    owners.push_back(owners_[v]);
    ranks_.push_back(local ? v - 1 : 0);
    if (!local) foreign_[ids_[v]] = to[v];
  }
  sent_.renumber(to);
  due_ = due_ < to.size() ? to[due_] : static_cast<Vertex>(ids.size());
  tsl::robin_map<Vertex, double> seeds;
  for (const auto& [v, reach] : seeds_) {
    if (to[v] != 0) seeds[to[v]] = reach;
  }
  seeds_ = std::move(seeds);
  ids_ = std::move(ids);
  owners_ = std::move(owners);
  told_.assign(ids_.size(), 0);
  handed_out_ = reduced_ = true;
  return to;
}

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
    if (!ball.known || ball.reach > longest_edge(std::span(p).first(corners))) continue;
    for (const TileId n : neighbours) {
      if (!reaches_well(ball, options_.around->bounds(n), d)) continue;
      for (int i = 0; i < corners; ++i) send(v[i], n);
    }
  }
}

Status TileTriangulation::receive(TileId from, std::span<const SharedPoint> points) {
  if (options_.rule == ExchangeRule::published) return receive_published(from, points);
  for (const SharedPoint& p : points) {
    stop_check_.step();
    ++counts_.received;
    if (p.tile == options_.self || p.tile.value >= options_.around->tiles() || !is_finite(p.at)) return refuse(from, p);
    if (const auto known = foreign_.find(p.id); known != foreign_.end()) {
      if (known->second != 0) record_received(known->second, from, p);
      continue;
    }
    BOOST_OUTCOME_TRY(v, add_foreign(p, false, around_));
    if (v == 0) {
      refused_.push_back({p, from});
    } else {
      record_received(v, from, p);
    }
  }
  return success();
}

// Nothing that a peer sends may stop the process.
Error TileTriangulation::refuse(TileId from, const SharedPoint& p) const {
  return error(Errc::internal, "tile " + to_string(options_.self) + ": tile " + to_string(from) + " told it of point " +
                                   to_string(p.id) + ", which it cannot have");
}

Result<Vertex> TileTriangulation::add_foreign(const SharedPoint& p, bool always, std::vector<Vertex>& around) {
  const auto mode = always ? InsertMode::always : InsertMode::if_local_neighbour;
  const Insertion result = kernel_->insert(p.at, false, mode, around);
  if (!result.inserted) {
    if (result.vertex != 0) return refuse(p.tile, p);  // equal coordinates must have one id
    foreign_[p.id] = 0;
    ++counts_.refused;
    return Vertex{0};
  }
  check(result.vertex == ids_.size(), "vertices are numbered in the order of insertion");
  ids_.push_back(p.id);
  owners_.push_back(p.tile);
  told_.push_back(p.told);
  if (reduced_) ranks_.push_back(0);
  foreign_[p.id] = result.vertex;
  ++counts_.inserted;
  return result.vertex;
}

CollectedTile TileTriangulation::collect(std::vector<Point> points, std::vector<PointId> ids, PendingFinals finals) {
  const std::size_t own = points.size();
  CollectInput input{.dimension = options_.dimension,
                     .self = options_.self,
                     .points = std::move(points),
                     .ids = std::move(ids),
                     .cells = {},
                     .fill = {},
                     .foreign = {},
                     .finals = std::move(finals),
                     .stop = options_.stop};
  input.foreign.reserve(foreign_.size());
  const std::size_t corners = static_cast<std::size_t>(options_.dimension) + 1;
  for (Vertex v = 1; v < ids_.size(); ++v) {
    if (is_local(v)) continue;
    input.foreign.push_back({kernel_->alive(v) ? kernel_->point(v) : Point{}, ids_[v], owners_[v], 0});
  }
  input.cells = kernel_->take_cells();
  const bool filled = reduced_ && !kernel_->can_freeze();
  kernel_.reset();
  if (reduced_) {  // vertices that stayed have new numbers: back to ranks, with the foreign vertices behind them
    const std::size_t stayed = ids_.size() - 1 - input.foreign.size();
    if (filled) input.fill.resize(input.cells.size());
    for (std::size_t c = 0; c < input.cells.size(); ++c) {
      Vertex* v = input.cells[c].vertices;
      if (v[0] == CellRecord::gap) continue;
      if (filled) {
        const bool all_local = std::all_of(v, v + corners, [&](Vertex w) { return is_local(w); });
        input.fill[c] = all_local && !open_cells_.contains(cell_key(v, options_.dimension));
      }
      for (std::size_t i = 0; i < corners; ++i) {
        if (v[i] == infinite_vertex) continue;
        v[i] = is_local(v[i]) ? ranks_[v[i]] + 1 : static_cast<Vertex>(v[i] - stayed + own);
      }
    }
  }
  throw_if_stopped(options_.stop);
  CollectedTile tile = collect_cells(std::move(input));
  counts_.useful = tile.mesh.points.size() - own;
  return tile;
}

std::size_t TileTriangulation::memory() const {
  std::size_t bytes = (kernel_ ? kernel_->memory() : 0) + ids_.capacity() * 8 + owners_.capacity() * 4 +
                      told_.capacity() * 4 + ranks_.capacity() * 4;
  bytes += foreign_.bucket_count() * 24 + sent_.memory() + seeds_.bucket_count() * 24 +
           refused_.capacity() * sizeof(Refused) + relied_.capacity() * 8 +
           refused_relied_.capacity() * sizeof(RefusedRelied) + open_cells_.bucket_count() * 24;
  for (const auto& [tile, list] : updates_) bytes += list.capacity() * sizeof(Vertex);
  return bytes;
}

}  // namespace tessera
