#include "src/tiling/tile/tile_triangulation.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <utility>

#include "src/base/check.h"
#include "src/base/flat_codec.h"
#include "src/tiling/tile/circumsphere.h"
#include "src/tiling/tile/collect.h"

namespace tessera {
namespace {

// The beginning of an image.
constexpr std::uint64_t magic = 0x3765676d49454c54u;

struct KnownSeed {
  std::uint64_t vertex;
  double reach;
};

}  // namespace

TileTriangulation::TileTriangulation(const TileOptions& options)
    : options_(options), kernel_(make_kernel(options.dimension, options.kernel)), known_(options.around) {}

void TileTriangulation::build(std::span<const Point> points, std::span<const PointId> ids, KeepPoints keep) {
  check(points.size() == ids.size(), "every point has an id");
  kernel_->build(points, keep, options_.stop);
  ids_.assign(1, PointId{});
  ids_.insert(ids_.end(), ids.begin(), ids.end());
  owners_.assign(points.size() + 1, options_.self);
  known_.set_vertices(points.size() + 1);
  due_ = static_cast<Vertex>(ids_.size());
}

void TileTriangulation::triangulate(std::span<const Point> points, std::span<const PointId> ids, KeepPoints keep) {
  build(points, ids, keep);
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

// The foreign vertices are those of stored cells, so none of them is refused, and nobody is noted to know them.
Status TileTriangulation::triangulate_changed(const ChangedTile& changed, KeepPoints keep) {
  check(changed.fresh.size() == changed.points.size(), "every point is fresh or not");
  check(!options_.around->periodic(), "only the results of clouds without a period are changed");
  check(options_.around->seeds().empty(), "only a first triangulation has seeds");
  build(changed.points, changed.ids, keep);
  fresh_.emplace(changed.fresh);
  seeded_ = true;
  for (const SharedPoint& p : changed.foreign) {
    stop_check_.step();
    BOOST_OUTCOME_TRYV(add_foreign(p, true, around_));
  }
  if (changed.common) {
    BOOST_OUTCOME_TRYV(know_common(*changed.common));
  }
  due_ = kernel_->vertices() + 1;
  counts_ = {};
  return success();
}

Status TileTriangulation::know_common(const SharedPoint& common) {
  if (!needs(common)) return success();
  SharedPoint plain = common;
  plain.told = 0;
  BOOST_OUTCOME_TRY(v, add_foreign(plain, true, around_));
  if ((common.told & fresh_bit) != 0) fresh_->learn(v);
  due_ = kernel_->vertices() + 1;
  return success();
}

// A tile needs the common point when none of its foreign points is nearer to it than all of its own. When rounding
// leaves that open, the tile takes the common point: to know a point more is never wrong.
bool TileTriangulation::needs(const SharedPoint& common) const {
  constexpr double rounding = 1e-9, underflow = 1e-280;
  if (common.tile == options_.self || foreign_.contains(common.id)) return false;
  double own = std::numeric_limits<double>::infinity(), other = own;
  for (Vertex v = 1; v < ids_.size(); ++v) {
    if (!kernel_->alive(v)) continue;
    const Point p = kernel_->point(v);
    const double x = p.x - common.at.x, y = p.y - common.at.y, z = p.z - common.at.z;
    double& least = is_local(v) ? own : other;
    least = std::min(least, x * x + y * y + z * z);
  }
  return !(own > underflow && other < own * (1 - rounding));
}

void TileTriangulation::settle() {
  if (ids_.empty()) build({}, {}, KeepPoints::copied);
  if (local_.empty()) {
    for (Vertex v = 1; v < ids_.size(); ++v) {
      if (is_local(v) && kernel_->alive(v)) local_[ids_[v]] = v;
    }
  }
  if (options_.left_out != LeftOut::forgotten_sent) {
    known_ = KnownByMessage(options_.around);
    known_.set_vertices(ids_.size());
  }
  if (options_.left_out != LeftOut::forgotten_fresh) fresh_.reset();
  refused_.clear();
  updates_.clear();
  refused_updates_.clear();
  for (auto at = foreign_.begin(); at != foreign_.end() && options_.left_out != LeftOut::forgotten_refused;) {
    at = at->second == 0 ? foreign_.erase(at) : std::next(at);
  }
  counts_ = {};
  seeded_ = true;
  due_ = live_from_ = kernel_->vertices() + 1;
}

Vertex TileTriangulation::vertex_of(PointId id) const {
  if (const auto own = local_.find(id); own != local_.end()) return own->second;
  const auto other = foreign_.find(id);
  return other == foreign_.end() ? 0 : other->second;
}

// Numbers of removed vertices are not used again, so a tile is built again, too, when most of its numbers are unused.
Result<LiveChange> TileTriangulation::change(std::span<const PointId> removed, std::span<const LocalPoint> added) {
  check(is_settled(), "a live tile is settled before it is changed");
  LiveChange out;
  std::vector<std::uint8_t> gone(ids_.size()), fresh(ids_.size());  // by vertex
  for (Vertex v = 1; fresh_ && v < ids_.size(); ++v) fresh[v] = fresh_->has(v) ? 1 : 0;
  std::vector<Vertex> to_remove;
  for (const PointId id : removed) {
    const Vertex v = vertex_of(id);
    if (v == 0 || std::exchange(gone[v], std::uint8_t{1}) != 0) continue;
    to_remove.push_back(v);
    out.lost |= is_local(v);
    kernel_->neighbours(v, around_);
    for (const Vertex w : around_) fresh[w] = is_local(w) ? 1 : 0;
  }
  for (const Vertex v : to_remove) {
    fresh[v] = 0;
    (is_local(v) ? local_ : foreign_).erase(ids_[v]);
  }
  const std::size_t living = local_.size() + foreign_.size();
  if (to_remove.size() * options_.rebuilt_from > living || ids_.size() - 1 > 2 * living + added.size() + 64) {
    BOOST_OUTCOME_TRYV(build_again(gone, fresh));
  } else {
    for (const Vertex v : to_remove) {
      stop_check_.step();
      kernel_->remove(v);
    }
  }
  live_from_ = kernel_->vertices() + 1;
  for (const LocalPoint& p : added) {
    stop_check_.step();
    const Insertion made = kernel_->insert(p.at, true, InsertMode::always, around_);
    if (!made.inserted) {
      if (!is_local(made.vertex)) return refuse(options_.self, {p.at, p.id, options_.self, 0});
      out.duplicates.emplace_back(p.id, ids_[made.vertex]);
      continue;
    }
    ids_.push_back(p.id);
    owners_.push_back(options_.self);
    known_.add_vertex(0);
    fresh.push_back(1);
    local_[p.id] = made.vertex;
  }
  out.begins = std::any_of(fresh.begin(), fresh.end(), [](std::uint8_t f) { return f != 0; });
  fresh_.emplace(std::span(fresh).subspan(1));
  due_ = kernel_->vertices() + 1;
  return out;
}

// Drops the foreign vertices that are in none of the tile's cells.
Status TileTriangulation::build_again(const std::vector<std::uint8_t>& gone, std::vector<std::uint8_t>& fresh) {
  std::vector<std::uint8_t> kept(ids_.size());
  if (kernel_->dimension() == options_.dimension) {
    kernel_->edges_from(1, [&](Vertex v, Vertex w) {
      kept[w] |= is_local(v) ? 1 : 0;
      kept[v] |= is_local(w) ? 1 : 0;
    });
  }
  std::vector<Point> points;
  std::vector<PointId> ids;
  std::vector<std::uint8_t> is_fresh(1);
  std::vector<SharedPoint> foreign;
  for (Vertex v = 1; v < ids_.size(); ++v) {
    if (!kernel_->alive(v) || gone[v] != 0) continue;
    if (is_local(v)) {
      points.push_back(kernel_->point(v));
      ids.push_back(ids_[v]);
      is_fresh.push_back(fresh[v]);
    } else if (kept[v] != 0) {
      foreign.push_back({kernel_->point(v), ids_[v], owners_[v], 0});
    }
  }
  foreign_.clear();
  local_.clear();
  build(points, ids, KeepPoints::copied);
  for (Vertex v = 1; v < ids_.size(); ++v) local_[ids_[v]] = v;
  for (const SharedPoint& p : foreign) {
    stop_check_.step();
    BOOST_OUTCOME_TRYV(add_foreign(p, true, around_));
  }
  fresh = std::move(is_fresh);
  fresh.resize(ids_.size());
  counts_ = {};
  return success();
}

Status TileTriangulation::know(std::span<const SharedPoint> points) {
  for (const SharedPoint& p : points) {
    stop_check_.step();
    if (p.tile == options_.self || foreign_.contains(p.id)) continue;
    BOOST_OUTCOME_TRYV(add_foreign({p.at, p.id, p.tile, 0}, true, around_));
  }
  due_ = kernel_->vertices() + 1;
  return success();
}

std::vector<SharedPoint> TileTriangulation::affected(std::size_t most) const {
  std::vector<Vertex> all;
  for (Vertex v = 1; v < live_from_; ++v) {
    if (is_local(v) && fresh_->has(v)) all.push_back(v);
  }
  const std::size_t stride = (all.size() + most - 1) / most;
  std::vector<SharedPoint> out;
  for (std::size_t k = 0; k < all.size(); k += stride) {
    out.push_back({kernel_->point(all[k]), ids_[all[k]], options_.self, 0});
  }
  return out;
}

std::optional<SharedPoint> TileTriangulation::old_point() const {
  for (Vertex v = 1; v < live_from_; ++v) {
    if (is_local(v) && kernel_->alive(v)) return SharedPoint{kernel_->point(v), ids_[v], options_.self, 0};
  }
  return std::nullopt;
}

SharedPoint TileTriangulation::new_point() const {
  const Vertex v = local_.begin()->second;
  return {kernel_->point(v), ids_[v], options_.self, fresh_bit};
}

Bounds TileTriangulation::changed() const {
  Bounds out;
  std::vector<Vertex> around;
  for (Vertex v = 1; fresh_ && v < ids_.size(); ++v) {
    if (!is_local(v) || !kernel_->alive(v) || !fresh_->has(v)) continue;
    out.add(kernel_->point(v));
    kernel_->neighbours(v, around);
    for (const Vertex w : around) out.add(kernel_->point(w));
  }
  return out;
}

std::unique_ptr<TileTriangulation> TileTriangulation::clone() const {
  check(is_settled(), "a live tile is settled before it is copied");
  auto copy = std::make_unique<TileTriangulation>(options_);
  copy->kernel_ = kernel_->clone();
  copy->ids_ = ids_;
  copy->owners_ = owners_;
  copy->foreign_ = foreign_;
  copy->local_ = local_;
  copy->known_ = known_;
  copy->fresh_ = fresh_;
  copy->seeded_ = true;
  copy->due_ = due_;
  copy->live_from_ = live_from_;
  return copy;
}

void TileTriangulation::change_owners(const std::function<TileId(TileId owner, const Point& at)>& owner_of) {
  check(is_settled(), "a live tile is settled before it gets other neighbours");
  for (Vertex v = 1; v < ids_.size(); ++v) {
    if (!is_local(v) && kernel_->alive(v)) owners_[v] = owner_of(owners_[v], kernel_->point(v));
  }
}

std::vector<LocalPoint> TileTriangulation::own() const {
  std::vector<LocalPoint> out;
  out.reserve(local_.size());
  for (Vertex v = 1; v < ids_.size(); ++v) {
    if (is_local(v) && kernel_->alive(v)) out.push_back({kernel_->point(v), ids_[v]});
  }
  return out;
}

TileMesh TileTriangulation::mesh(std::span<const LocalPoint> order) const {
  CollectInput input{.dimension = options_.dimension,
                     .self = options_.self,
                     .points = {},
                     .ids = {},
                     .cells = {},
                     .fill = {},
                     .foreign = {},
                     .finals = {},
                     .stop = options_.stop};
  std::vector<Vertex> to(ids_.size());
  for (const LocalPoint& p : order) {
    input.points.push_back(p.at);
    input.ids.push_back(p.id);
    to[local_.at(p.id)] = static_cast<Vertex>(input.ids.size());
  }
  for (Vertex v = 1; v < ids_.size(); ++v) {
    if (is_local(v) || !kernel_->alive(v)) continue;
    input.foreign.push_back({kernel_->point(v), ids_[v], owners_[v], 0});
    to[v] = static_cast<Vertex>(input.ids.size() + input.foreign.size());
  }
  input.cells = kernel_->clone()->take_cells();
  for (std::size_t c = 0; c < input.cells.size(); ++c) {
    Vertex* v = input.cells[c].vertices;
    if (v[0] == CellRecord::gap) continue;
    for (int i = 0; i <= options_.dimension; ++i) v[i] = to[v[i]];
  }
  return collect_cells(std::move(input)).whole();
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
  check(!handed_out_ && !fresh_ && updates_.empty(), "a tile is reduced once, before it announces");
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

std::uint64_t TileTriangulation::discard(std::span<const Point> points, const Box& box, bool quick,
                                         const Kernel::TakeVertices& told) {
  if (!kernel_->can_freeze()) {
    const FinalCells finals = reduce(points, box, quick);
    std::vector<Vertex> vertices;
    for (std::size_t c = 0; c < finals.rows.size(); ++c) {
      const Vertex* v = finals.rows[c].vertices;
      vertices.insert(vertices.end(), v, v + options_.dimension + 1);
    }
    told(vertices);
    return finals.rows.size();
  }
  check(!handed_out_ && !fresh_ && updates_.empty(), "a tile is reduced once, before it announces");
  if (kernel_->dimension() < options_.dimension) return 0;
  throw_if_stopped(options_.stop);
  const std::uint64_t gone = kernel_->discard(
      [&](const Vertex* cell) {
        stop_check_.step();
        return surely_final(cell, points, box);
      },
      told);
  handed_out_ = true;
  if (!quick) forget_vertices(points.size());
  return gone;
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
  due_ = due_ < to.size() ? to[due_] : static_cast<Vertex>(ids.size());
  tsl::robin_map<Vertex, double> seeds;
  for (const auto& [v, reach] : seeds_) {
    if (to[v] != 0) seeds[to[v]] = reach;
  }
  seeds_ = std::move(seeds);
  ids_ = std::move(ids);
  owners_ = std::move(owners);
  known_.renumber(to, ids_.size());
  handed_out_ = reduced_ = true;
  return to;
}

Status TileTriangulation::receive(TileId from, std::span<const SharedPoint> points) {
  if (options_.rule == ExchangeRule::published) return receive_published(from, points);
  for (const SharedPoint& p : points) {
    stop_check_.step();
    ++counts_.received;
    const bool sound = p.tile != options_.self && options_.around->has_tile(p.tile) &&
                       offset_code(p.id) == offset_code(p.tile) && is_finite(p.at);
    if (!sound) return refuse(from, p);
    if (fresh_) {
      BOOST_OUTCOME_TRYV(receive_changed(from, p));
    } else {
      BOOST_OUTCOME_TRYV(receive_first(from, p));
    }
  }
  return success();
}

Status TileTriangulation::receive_first(TileId from, const SharedPoint& p) {
  if (const auto known = foreign_.find(p.id); known != foreign_.end()) {
    if (known->second != 0) record_received(known->second, from, p);
    return success();
  }
  BOOST_OUTCOME_TRY(v, add_foreign(p, false, around_));
  if (v == 0) {
    // Of a sender that is periodic the tile does not know which image has spoken.
    refused_.push_back({p, options_.around->periodic() ? p.tile : from});
  } else {
    record_received(v, from, p);
  }
  return success();
}

// Only the owner of a point, and a tile that knows that the point is fresh, are noted to know the point: a quote says
// nothing about its sender.
Status TileTriangulation::receive_changed(TileId from, SharedPoint p) {
  const bool fresh = (p.told & fresh_bit) != 0;
  p.told &= ~fresh_bit;
  const bool quoted = !fresh && from != p.tile;
  const auto known = foreign_.find(p.id);
  Vertex v = known == foreign_.end() ? 0 : known->second;
  if (known == foreign_.end()) {
    BOOST_OUTCOME_TRY(added, add_foreign(p, false, around_));
    v = added;
    if (v == 0 && fresh) fresh_->learn_refused(p.id);
    if (v == 0) refused_.push_back({p, quoted ? options_.self : from});
    if (v != 0 && fresh) fresh_->arrive(v);
  } else if (v == 0) {
    if (fresh && fresh_->learn_refused(p.id)) refused_.push_back({p, from});
  } else if (fresh && options_.left_out != LeftOut::answers) {
    fresh_->learn(v);
  }
  if (v == 0) return success();
  if (quoted) {
    known_.record_quoted(v, p.told);
  } else {
    record_received(v, from, p);
  }
  return success();
}

// Nothing that a peer sends may stop the process.
Error TileTriangulation::refuse(TileId from, const SharedPoint& p) const {
  return error(Errc::internal, "tile " + to_string(options_.self) + ": tile " + to_string(from) + " has sent point " +
                                   to_string(p.id) +
                                   ", which no sound tile sends: the point belongs to this tile or to no tile, is not "
                                   "finite, or has the coordinates of another point");
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
  known_.add_vertex(p.told);
  if (fresh_) fresh_->add_vertex();
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

RestOfTile TileTriangulation::collect_rest(const Kernel::TakeVertices& told) {
  std::vector<Point> at(ids_.size());  // by vertex; saved here, as the kernel forgets points with its cells
  for (Vertex v = 1; v < ids_.size(); ++v) {
    if (!is_local(v) && kernel_->alive(v)) at[v] = kernel_->point(v);
  }
  const int corners = options_.dimension + 1;
  const CellRecords rows = kernel_->take_cells();
  const bool filled = reduced_ && !kernel_->can_freeze();
  kernel_.reset();
  RestOfTile rest;
  const TileId self = rank_of(options_.self);
  std::vector<std::uint8_t> used(ids_.size());
  std::vector<Vertex> main;
  for (std::size_t c = 0; c < rows.size(); ++c) {
    const Vertex* v = rows[c].vertices;
    if (v[0] == CellRecord::gap || std::find(v, v + corners, infinite_vertex) != v + corners) continue;
    const auto own = std::count_if(v, v + corners, [&](Vertex w) { return is_local(w); });
    if (own == 0) continue;
    if (filled && own == corners && !open_cells_.contains(cell_key(v, options_.dimension))) continue;
    stop_check_.step();
    ++rest.cells;
    bool is_main = true;
    if (own < corners) {
      for (int i = 0; i < corners; ++i) {
        used[v[i]] = 1;
        is_main &= rank_of(owners_[v[i]]) >= self;
      }
    }
    if (is_main) {
      ++rest.main_cells;
      main.insert(main.end(), v, v + corners);
      if (main.size() >= 16384) {
        told(main);
        main.clear();
      }
    }
  }
  told(main);
  for (Vertex v = 1; v < ids_.size(); ++v) {
    if (used[v] && !is_local(v)) rest.foreign.push_back({at[v], ids_[v], owners_[v], 0});
  }
  counts_.useful = rest.foreign.size();
  return rest;
}

std::size_t TileTriangulation::memory() const {
  std::size_t bytes =
      (kernel_ ? kernel_->memory() : 0) + ids_.capacity() * 8 + owners_.capacity() * 4 + ranks_.capacity() * 4;
  if (fresh_) bytes += fresh_->memory();
  bytes += foreign_.bucket_count() * 24 + known_.memory() + seeds_.bucket_count() * 24 +
           refused_.capacity() * sizeof(Refused) + open_cells_.bucket_count() * 24;
  for (const auto& [tile, list] : updates_) bytes += list.capacity() * sizeof(Vertex);
  return bytes;
}

std::vector<SharedPoint> TileTriangulation::foreign_vertices() const {
  std::vector<SharedPoint> out;
  for (Vertex v = 1; v < ids_.size(); ++v) {
    if (!is_local(v) && kernel_->alive(v)) out.push_back({kernel_->point(v), ids_[v], owners_[v], 0});
  }
  return out;
}

// A sleeping tile as bytes: counts first, then flat arrays. The image is read on the machine and by the version that
// wrote it, so layout and byte order are those of memory. load() checks lengths and ranges all the same.
BigVector<std::byte> TileTriangulation::save() const {
  FlatWriter out;
  KernelImage image = kernel_->save();
  const std::vector<std::uint64_t> sent = known_.sent();
  out.reserve(image.points.size() * 48 + image.cells.vertices.size() * 8 + sent.size() * 8 + seeds_.size() * 16 +
              open_cells_.size() * 16 + known_.relied().size() * 8 +
              known_.refused_relied().size() * sizeof(KnownByMessage::RefusedRelied) + 1024);
  out.value(magic);
  out.value(options_.self);
  out.value(static_cast<std::int32_t>(options_.dimension));
  out.value(options_.kernel);
  out.value(static_cast<std::uint8_t>(handed_out_));
  out.value(static_cast<std::uint8_t>(reduced_));
  out.value(counts_);
  out.value(static_cast<std::int32_t>(image.dimension));
  out.last(image.points);
  out.last(image.local);
  out.last(image.alive);
  out.last(image.cells.vertices);
  out.last(image.cells.neighbors);
  out.value(image.frozen);
  out.list(ids_);
  out.list(owners_);
  out.list(known_.told_bits());
  out.list(ranks_);
  std::vector<KnownSeed> seeds;
  for (const auto& [vertex, reach] : seeds_) seeds.push_back({vertex, reach});
  out.list(seeds);
  out.value(due_);
  out.value(static_cast<std::uint8_t>(seeded_));
  out.list(sent);
  out.list(known_.relied());
  out.list(known_.refused_relied());
  out.list(std::vector<CellKey>(open_cells_.begin(), open_cells_.end()));
  out.value(static_cast<std::uint8_t>(fresh_ ? 1 : 0));
  if (fresh_) {
    const FreshPoints::State fresh = fresh_->state();
    out.list(fresh.fresh);
    out.list(fresh.due);
    out.list(fresh.quoted);
    out.list(fresh.refused);
    out.list(fresh.refused_quotes);
  }
  return out.take();
}

bool TileTriangulation::load(BigVector<std::byte> bytes) {
  FlatReader in(bytes);
  std::uint64_t found = 0;
  TileId self;
  std::int32_t dimension = 0;
  std::uint8_t handed_out = 0, reduced = 0, seeded = 0;
  KernelKind kernel = KernelKind::flat;
  ExchangeCounts counts;
  KernelImage image;
  std::vector<PointId> ids;
  std::vector<TileId> owners;
  KnownByMessage::State known;
  std::vector<std::uint32_t> ranks;
  std::vector<KnownSeed> seeds;
  Vertex due = 0;
  std::vector<CellKey> open_cells;
  std::uint8_t changed = 0;
  FreshPoints::State fresh;
  const bool read =
      in.value(found) && found == magic && in.value(self) && self == options_.self && in.value(dimension) &&
      dimension == options_.dimension && in.value(kernel) && kernel == options_.kernel && in.value(handed_out) &&
      in.value(reduced) && in.value(counts) && in.value(image.dimension) && in.list(image.points) &&
      in.list(image.local) && in.list(image.alive) && in.list(image.cells.vertices) && in.list(image.cells.neighbors) &&
      in.value(image.frozen) && in.list(ids) && in.list(owners) && in.list(known.told) && in.list(ranks) &&
      in.list(seeds) && in.value(due) && in.value(seeded) && in.list(known.sent) && in.list(known.relied) &&
      in.list(known.refused_relied) && in.list(open_cells) && in.value(changed) &&
      (changed == 0 || (in.list(fresh.fresh) && in.list(fresh.due) && in.list(fresh.quoted) && in.list(fresh.refused) &&
                        in.list(fresh.refused_quotes))) &&
      in.at_end();
  if (!read) return false;
  const std::size_t n = image.points.size() + 1;
  if (ids.size() != n || owners.size() != n || known.told.size() != n || (reduced ? ranks.size() != n : !ranks.empty()))
    return false;
  if (due == 0 || due > n || (changed != 0 && !fresh.fits(n))) return false;
  for (const auto& seed : seeds) {
    if (seed.vertex >= n) return false;
  }
  for (const auto* pairs : {&known.sent, &known.relied}) {
    if (std::any_of(pairs->begin(), pairs->end(), [&](std::uint64_t pair) { return pair >> 32 >= n; })) return false;
  }
  // A tile wakes up when memory is short, so there are never more than two copies of it.
  BigVector<std::byte>().swap(bytes);
  if (!kernel_->load(image)) return false;
  image = {};
  ids_ = std::move(ids);
  owners_ = std::move(owners);
  ranks_ = std::move(ranks);
  handed_out_ = handed_out != 0;
  reduced_ = reduced != 0;
  counts_ = counts;
  foreign_.clear();
  for (Vertex v = 1; v < n; ++v) {
    if (!is_local(v)) foreign_[ids_[v]] = kernel_->alive(v) ? v : 0;
  }
  seeds_.clear();
  for (const auto& seed : seeds) seeds_[static_cast<Vertex>(seed.vertex)] = seed.reach;
  due_ = due;
  seeded_ = seeded != 0;
  refused_.clear();
  known_.restore(std::move(known));
  fresh_.reset();
  if (changed != 0) fresh_.emplace(std::move(fresh));
  for (const auto& r : known_.refused_relied()) foreign_.insert({r.point.id, 0});  // it stays refused
  open_cells_ = {open_cells.begin(), open_cells.end()};
  updates_.clear();
  return true;
}

}  // namespace tessera
