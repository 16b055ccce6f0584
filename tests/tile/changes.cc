#include "tests/tile/changes.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "src/base/check.h"
#include "src/base/mixed_bits.h"
#include "src/geometry/kernel/kernel.h"
#include "src/geometry/reference/clouds.h"
#include "src/geometry/reference/reference.h"
#include "src/tiling/tile/changed_points.h"
#include "src/tiling/tile/holes.h"
#include "src/tiling/tile/tile_triangulation.h"

namespace tessera::testing {
namespace {

using Rng = std::mt19937_64;
using Owner = std::function<std::uint32_t(const Point&)>;
using Cloud = std::map<PointId, Point>;

double distance(const Point& a, const Point& b) { return std::hypot(a.x - b.x, a.y - b.y, a.z - b.z); }

struct Mail {
  std::uint32_t from, to;
  std::vector<SharedPoint> points;
  std::uint32_t from_life, to_life, epoch;
};

struct Tile {
  std::optional<TileMesh> mesh;             // stored
  std::unique_ptr<TileTriangulation> live;  // null: not live, or without points
  std::size_t seen = 0;                     // so many removed points the live tile has been told of
  // Of this change.
  ChangedPoints begin;
  std::vector<Point> points;
  std::vector<PointId> ids;
  bool begins = false;
  std::size_t added = 0;                 // of points, the last
  PointIds filled;                       // removed points: the tile knows all points around their holes
  std::vector<SharedPoint> around;       // these
  std::unique_ptr<TileTriangulation> t;  // null: asleep
  bool due = false;
  std::vector<Mail> waiting;
  std::uint32_t epoch = 0;
  std::set<TileId> reborn;  // to be told again
};

// A change of a cloud: what is removed and what is added.
struct Change {
  PointIds removed;
  std::vector<LocalPoint> added;
};

struct Setting {
  std::vector<PointId> removed;  // in all changes so far
  int dimension;
  std::uint32_t tiles;
  KernelKind kernel;
  Owner owner;
  std::size_t seen_before = 0;  // of removed: before this change
  const KnownFromStart* around;
  const ChangeOptions* options;
};

// One exchange over stored tiles. Tables of lives reach each tile at a time of its own; what was sent by the dead or to
// them is lost or comes late.
class Exchange {
 public:
  Exchange(const Setting& setting, std::vector<Tile>& tiles, Rng& rng, ChangeReport& report)
      : setting_(setting), tile_(tiles), rng_(rng), report_(report), lives_{std::vector<std::uint32_t>(tiles.size())} {
    for (Tile& t : tile_) {
      t.t.reset();
      t.due = false;
      t.waiting.clear();
      t.epoch = 0;
      t.reborn.clear();
    }
  }
  // Returns what is wrong, or "".
  std::string run(const Change& change, std::span<const SharedPoint> stayed);

 private:
  void prepare(const Change& change, std::span<const SharedPoint> stayed);
  void fill_holes(const Change& change, std::span<const SharedPoint> stayed);
  void choose_common(const Change& change, std::span<const SharedPoint> stayed);
  void know_least(Tile& tile, std::uint32_t self) const;
  void start(std::uint32_t i);
  void start_live(std::uint32_t i);
  void store(std::uint32_t i);
  void splay(std::uint32_t i);
  void sleep(std::uint32_t i);
  void post(std::uint32_t i);
  void deliver(std::size_t which);
  void lose();
  void rejoin(std::uint32_t i);
  bool act();
  TileOptions options_of(std::uint32_t i) const;
  bool mutant(Mutant m) const { return setting_.options->mutant == m; }
  std::uint32_t life(std::uint32_t i) const { return lives_.back()[i]; }
  bool coin() { return rng_() % 2 == 0; }

  const Setting& setting_;
  std::vector<Tile>& tile_;
  Rng& rng_;
  ChangeReport& report_;
  std::optional<SharedPoint> common_;
  std::vector<std::vector<std::uint32_t>> lives_;  // by epoch, then by tile
  std::vector<Mail> mail_;
  std::uint64_t losses_left_ = 0;
  std::uint64_t style_ = 0;
  std::string wrong_;
};

TileOptions Exchange::options_of(std::uint32_t i) const {
  TileOptions out{TileId{i}, setting_.dimension, setting_.kernel, ExchangeRule::introduce, setting_.around};
  if (i % 2 == 0) out.rebuilt_from = 0;  // so that few points are enough to test both ways
  if (mutant(Mutant::foreign_pairs)) out.left_out = LeftOut::foreign_pairs;
  if (mutant(Mutant::old_arrivals)) out.left_out = LeftOut::old_arrivals;
  if (mutant(Mutant::refused_fresh)) out.left_out = LeftOut::refused_fresh;
  if (mutant(Mutant::answers)) out.left_out = LeftOut::answers;
  if (mutant(Mutant::forgotten_sent)) out.left_out = LeftOut::forgotten_sent;
  if (mutant(Mutant::forgotten_fresh)) out.left_out = LeftOut::forgotten_fresh;
  if (mutant(Mutant::forgotten_refused)) out.left_out = LeftOut::forgotten_refused;
  if (mutant(Mutant::replayed_quotes)) out.left_out = LeftOut::replayed_quotes;
  return out;
}

// Some of the holes that can be filled.
void Exchange::fill_holes(const Change& change, std::span<const SharedPoint> stayed) {
  for (Tile& t : tile_) {
    t.filled = {};
    t.around.clear();
  }
  std::vector<Point> points;
  for (const SharedPoint& p : stayed) points.push_back(p.at);
  const auto kernel = make_kernel(setting_.dimension, KernelKind::cgal);
  kernel->build(points, KeepPoints::copied, {});
  const bool span = kernel->dimension() == setting_.dimension;
  const std::uint64_t style = rng_() % 4;  // none, some, all
  for (std::uint32_t i = 0; i < setting_.tiles && span && style > 0 && !setting_.options->live; ++i) {
    if (!tile_[i].mesh) continue;
    for (const Hole& hole : find_holes(TileId{i}, *tile_[i].mesh, change.removed)) {
      if ((!hole.whole && !mutant(Mutant::shared_holes)) || (style == 1 && coin())) continue;
      tile_[i].filled.insert(hole.removed);
      for (const TileId beside : hole.beside) {
        Tile& t = tile_[beside.value];
        t.filled.insert(hole.removed);
        if (!mutant(Mutant::untold_holes)) t.around.insert(t.around.end(), hole.around.begin(), hole.around.end());
      }
    }
  }
}

void Exchange::prepare(const Change& change, std::span<const SharedPoint> stayed) {
  fill_holes(change, stayed);
  std::vector<std::vector<LocalPoint>> added(setting_.tiles);
  for (const LocalPoint& p : change.added) added[setting_.owner(p.at)].push_back(p);
  const bool seeds = rng_() % 4 == 0;
  for (std::uint32_t i = 0; i < setting_.tiles; ++i) {
    Tile& t = tile_[i];
    TileMesh nothing;
    nothing.dimension = setting_.dimension;
    t.begin = change_points(t.mesh ? *t.mesh : nothing, TileId{i}, change.removed, added[i], t.filled);
    for (const SharedPoint& p : t.around) {
      const bool knows =
          std::any_of(t.begin.foreign.begin(), t.begin.foreign.end(), [&](auto& f) { return f.id == p.id; });
      if (!knows && p.tile.value != i) t.begin.foreign.push_back(p);
    }
    if (mutant(Mutant::affected_not_fresh)) {
      for (std::size_t k = 0; k < t.begin.fresh.size(); ++k) {
        t.begin.fresh[k] = k + added[i].size() >= t.begin.fresh.size() ? 1 : 0;
      }
    }
    if (mutant(Mutant::removed_foreign) && t.mesh) {
      for (std::size_t v = 0; v < t.mesh->points.size(); ++v) {
        if (t.mesh->owners[v].value == i || !change.removed.contains(t.mesh->ids[v])) continue;
        t.begin.foreign.push_back({t.mesh->points[v], t.mesh->ids[v], t.mesh->owners[v], 0});
      }
    }
    t.begins = t.begin.begins();
    t.added = added[i].size();
    if (mutant(Mutant::begin_if_changed)) t.begins &= t.begin.lost || !added[i].empty();
    if (mutant(Mutant::no_foreign) && t.begins) t.begin.foreign.clear();
    for (const SharedPoint& p : stayed) {  // any point that stays may be known
      const bool knows =
          std::any_of(t.begin.foreign.begin(), t.begin.foreign.end(), [&](auto& f) { return f.id == p.id; });
      if (seeds && !knows && p.tile.value != i && rng_() % 4 == 0) t.begin.foreign.push_back(p);
    }
    t.points.clear();
    t.ids.clear();
    for (const LocalPoint& p : t.begin.own) {
      t.points.push_back(p.at);
      t.ids.push_back(p.id);
    }
  }
  choose_common(change, stayed);
}

void Exchange::choose_common(const Change& change, std::span<const SharedPoint> stayed) {
  std::vector<SharedPoint> added;
  for (const LocalPoint& p : change.added) added.push_back({p.at, p.id, TileId{setting_.owner(p.at)}, fresh_bit});
  std::vector<SharedPoint> from(stayed.begin(), stayed.end());
  if (from.empty() || (mutant(Mutant::new_common) && !added.empty())) from = added;
  if (mutant(Mutant::no_common) || from.empty()) return;
  common_ = from[rng_() % from.size()];
  if (!mutant(Mutant::least_common)) return;
  from.insert(from.end(), added.begin(), added.end());
  common_ = *std::min_element(from.begin(), from.end(), [](auto& a, auto& b) { return a.at < b.at; });
  for (std::uint32_t i = 0; i < setting_.tiles; ++i) know_least(tile_[i], i);
}

void Exchange::know_least(Tile& tile, std::uint32_t self) const {
  const auto below = [&](const auto& p) { return p.at < common_->at || p.at == common_->at; };
  if (!tile.begins || common_->tile.value == self) return;
  if (std::any_of(tile.begin.foreign.begin(), tile.begin.foreign.end(), below)) return;
  if (std::any_of(tile.begin.own.begin(), tile.begin.own.end(), below)) return;
  tile.begin.foreign.push_back({common_->at, common_->id, common_->tile, 0});
}

// The points that stay are known by the live tile, or are seeds.
void Exchange::start_live(std::uint32_t i) {
  Tile& t = tile_[i];
  if (t.live) {
    t.t = t.live->clone();
  } else {
    t.t = std::make_unique<TileTriangulation>(options_of(i));
    t.t->settle();
  }
  std::vector<LocalPoint> added(t.begin.own.end() - static_cast<std::ptrdiff_t>(t.added), t.begin.own.end());
  std::shuffle(added.begin(), added.end(), rng_);
  std::span<const PointId> removed(setting_.removed);
  removed = removed.subspan(mutant(Mutant::missed_removals) ? setting_.seen_before : t.seen);
  const auto changed = t.t->change(removed, added);
  if (!changed) {
    wrong_ = changed.error().where;
    return;
  }
  if (changed.value().lost != t.begin.lost || changed.value().begins != t.begins) {
    wrong_ = "tile " + std::to_string(i) + ": a live tile finds other fresh points";
  }
  std::shuffle(t.begin.foreign.begin(), t.begin.foreign.end(), rng_);
  Status known = t.t->know(t.begin.foreign);
  if (known && t.begins && common_) known = t.t->know_common(*common_);
  if (!known) wrong_ = known.error().where;
}

void Exchange::start(std::uint32_t i) {
  Tile& t = tile_[i];
  if (setting_.options->live) {
    start_live(i);
    t.due = true;
    ++report_.woken;
    report_.begun += t.begins ? 1 : 0;
    return;
  }
  t.t = std::make_unique<TileTriangulation>(options_of(i));
  std::shuffle(t.begin.foreign.begin(), t.begin.foreign.end(), rng_);
  std::optional<SharedPoint> common = t.begins ? common_ : std::nullopt;
  if (mutant(Mutant::least_common)) common.reset();
  if (mutant(Mutant::common_for_the_lonely) && !t.begin.foreign.empty()) common.reset();
  std::vector<std::uint8_t> fresh = t.begin.fresh;
  if (!t.begins) std::fill(fresh.begin(), fresh.end(), std::uint8_t{0});  // a mutant
  const Status begun = t.t->triangulate_changed({t.points, t.ids, fresh, t.begin.foreign, common});
  if (!begun) wrong_ = begun.error().where;
  t.due = true;
  ++report_.woken;
  report_.begun += t.begins ? 1 : 0;
}

void Exchange::sleep(std::uint32_t i) {
  auto again = std::make_unique<TileTriangulation>(options_of(i));
  if (!again->load(tile_[i].t->save())) wrong_ = "an image cannot be loaded";
  tile_[i].t = std::move(again);
}

void Exchange::splay(std::uint32_t i) {
  Tile& t = tile_[i];
  if (!t.t) start(i);
  if (!setting_.options->live && rng_() % 8 == 0) sleep(i);
  if (!t.reborn.empty()) {
    const std::vector<TileId> reborn(t.reborn.begin(), t.reborn.end());
    t.reborn.clear();
    if (mutant(Mutant::no_replay)) {
      t.t->forget_told_bits();
    } else {
      t.t->replay_to(reborn);
    }
  }
  std::shuffle(t.waiting.begin(), t.waiting.end(), rng_);
  for (Mail& mail : t.waiting) {
    for (SharedPoint& p : mail.points) {
      if (mail.epoch != t.epoch) p.told &= fresh_bit;
    }
    const Status received = t.t->receive(TileId{mail.from}, mail.points);
    if (!received) wrong_ = received.error().where;
  }
  t.waiting.clear();
  t.t->introduce();
  t.due = false;
  if (t.t->due()) wrong_ = "something is due after a splay";
  post(i);
}

void Exchange::post(std::uint32_t i) {
  const std::uint32_t epoch = tile_[i].epoch;
  for (auto& [to, points] : tile_[i].t->take_updates()) {
    report_.sent += points.size();
    const Mail mail{i, to.value, {}, life(i), lives_[epoch][to.value], epoch};
    if (coin()) {
      mail_.push_back(mail);
      mail_.back().points = std::move(points);
      continue;
    }
    for (const SharedPoint& p : points) {
      mail_.push_back(mail);
      mail_.back().points = {p};
    }
  }
}

void Exchange::deliver(std::size_t which) {
  std::swap(mail_[which], mail_.back());
  Mail mail = std::move(mail_.back());
  mail_.pop_back();
  Tile& to = tile_[mail.to];
  if (mail.to_life != life(mail.to) || mail.from_life < lives_[to.epoch][mail.from]) return;
  to.waiting.push_back(std::move(mail));
}

// One tile, half of them, or some with another. They begin with the last table.
void Exchange::lose() {
  --losses_left_;
  std::vector<bool> dead(setting_.tiles);
  const std::uint64_t how = rng_() % 3, one = rng_() % setting_.tiles;
  for (std::uint32_t i = 0; i < setting_.tiles; ++i) {
    dead[i] = how == 0 ? coin() : i == one || (how == 2 && rng_() % 4 == 0);
  }
  lives_.push_back(lives_.back());
  std::erase_if(mail_, [&](const Mail& mail) { return (dead[mail.from] || dead[mail.to]) && coin(); });
  for (std::uint32_t i = 0; i < setting_.tiles; ++i) {
    if (!dead[i]) continue;
    ++lives_.back()[i];
    ++report_.lost;
    Tile& t = tile_[i];
    t.t.reset();
    t.due = false;
    t.waiting.clear();
    t.reborn.clear();
    t.epoch = static_cast<std::uint32_t>(lives_.size()) - 1;
  }
}

// One table after the other, or the last at once.
void Exchange::rejoin(std::uint32_t i) {
  Tile& t = tile_[i];
  const std::uint32_t next = coin() ? t.epoch + 1 : static_cast<std::uint32_t>(lives_.size()) - 1;
  for (std::uint32_t k = 0; k < setting_.tiles; ++k) {
    if (k != i && t.t && lives_[next][k] != lives_[t.epoch][k]) t.reborn.insert(TileId{k});
  }
  t.epoch = next;
  std::erase_if(t.waiting, [&](const Mail& mail) { return mail.from_life < lives_[next][mail.from]; });
  t.due |= t.t != nullptr;
}

// Returns false when all is quiet.
bool Exchange::act() {
  std::vector<std::uint32_t> starts, splays, rejoins;
  for (std::uint32_t i = 0; i < setting_.tiles; ++i) {
    const Tile& t = tile_[i];
    if (t.begins && !t.t) starts.push_back(i);
    if (!t.waiting.empty() || (t.t && t.due)) splays.push_back(i);
    if (t.epoch + 1 < lives_.size()) rejoins.push_back(i);
  }
  if (!rejoins.empty() && rng_() % (style_ == 1 ? 2 : 6) == 0) return rejoin(rejoins[rng_() % rejoins.size()]), true;
  const std::size_t count = starts.size() + splays.size() + mail_.size();
  if (losses_left_ > 0 && (count == 0 ? coin() : rng_() % 10 == 0)) return lose(), true;
  if (count == 0) {
    if (rejoins.empty()) return false;
    return rejoin(rejoins[rng_() % rejoins.size()]), true;
  }
  std::size_t choice = rng_() % count;
  if (style_ == 1 && !mail_.empty() && rng_() % 4 != 0) choice = starts.size() + splays.size() + rng_() % mail_.size();
  if (style_ == 2 && !starts.empty() && coin()) choice = rng_() % starts.size();
  if (choice < starts.size()) {
    start(starts[choice]);
    if (coin()) splay(starts[choice]);
  } else if (choice < starts.size() + splays.size()) {
    splay(splays[choice - starts.size()]);
  } else {
    deliver(choice - starts.size() - splays.size());
  }
  return true;
}

std::string Exchange::run(const Change& change, std::span<const SharedPoint> stayed) {
  constexpr int steps_max = 200'000;
  prepare(change, stayed);
  style_ = rng_() % 3;  // lazy, prompt, mixed
  losses_left_ = setting_.options->losses ? 1 + rng_() % 3 : 0;
  for (int step = 0; wrong_.empty() && act(); ++step) {
    if (step == steps_max) wrong_ = "it does not end";
  }
  for (std::uint32_t i = 0; i < setting_.tiles && wrong_.empty(); ++i) {
    Tile& t = tile_[i];
    if (t.points.empty()) {
      t.mesh.reset();
      t.live.reset();
      continue;
    }
    if (!t.t && (t.begin.lost || t.begin.reshaped)) start(i);  // its cells follow from what is left
    if (!t.t) {
      if (!t.mesh) wrong_ = "tile " + std::to_string(i) + " has points and never began";
      continue;
    }
    if (t.t->kernel_dimension() < setting_.dimension) {
      wrong_ = "tile " + std::to_string(i) + " is flat";
    } else {
      store(i);
    }
  }
  for (Tile& t : tile_) {  // also those that slept
    if (t.live && wrong_.empty()) t.mesh = t.live->mesh(t.live->own());
  }
  return wrong_;
}

void Exchange::store(std::uint32_t i) {
  Tile& t = tile_[i];
  if (!setting_.options->live) {
    t.mesh = t.t->collect(t.points, t.ids, {}).whole();
    return;
  }
  t.t->settle();
  t.live = std::move(t.t);
  t.seen = setting_.removed.size();
}

// The points from which a world draws: a cloud of the reference, or a lattice; in a quarter of all some are far away.
std::vector<Point> universe(int dimension, std::size_t count, Rng& rng) {
  std::vector<Point> out;
  if (rng() % 3 == 0) {
    const auto& kinds = cloud_kinds();
    for (const LocalPoint& p : make_cloud(kinds[rng() % kinds.size()], dimension, count, rng())) out.push_back(p.at);
  } else {
    constexpr std::uint64_t sides[] = {2, 3, 4, 6, 12, 40};
    const std::uint64_t side = sides[rng() % 6], height = rng() % 4 == 0 ? 2 : side;
    std::set<Point> seen;
    for (std::size_t k = 0; k < 3 * count && out.size() < count; ++k) {
      Point p;
      p.x = static_cast<double>(rng() % side);
      p.y = static_cast<double>(rng() % (dimension == 3 ? side : height));
      if (dimension == 3) p.z = static_cast<double>(rng() % height);
      if (seen.insert(p).second) out.push_back(p);
    }
  }
  for (int k = rng() % 4 == 0 ? 3 : 0; k > 0; --k) {
    const Point& q = out[rng() % out.size()];
    const double far = rng() % 2 == 0 ? -1000 : 100;
    const Point p = without_negative_zero({q.x * far - 50, q.y * far + 7, dimension == 3 ? q.z * far - 9 : 0});
    if (std::find(out.begin(), out.end(), p) == out.end()) out.push_back(p);
  }
  std::shuffle(out.begin(), out.end(), rng);
  return out;
}

// Stripes between points, the nearest of some points, or a hash, so that tiles have no shape at all.
Owner partition(const std::vector<Point>& pool, std::uint32_t tiles, Rng& rng) {
  const std::uint64_t how = rng() % 4;
  if (how == 0) {
    std::vector<double> cuts;
    for (std::uint32_t k = 1; k < tiles; ++k) cuts.push_back(pool[rng() % pool.size()].x);
    std::sort(cuts.begin(), cuts.end());
    return [cuts](const Point& p) {
      return static_cast<std::uint32_t>(std::upper_bound(cuts.begin(), cuts.end(), p.x) - cuts.begin());
    };
  }
  if (how == 1) {
    std::vector<Point> sites;
    for (std::uint32_t k = 0; k < tiles; ++k) sites.push_back(pool[rng() % pool.size()]);
    return [sites](const Point& p) {
      const auto nearer = [&](const Point& a, const Point& b) { return distance(a, p) < distance(b, p); };
      return static_cast<std::uint32_t>(std::min_element(sites.begin(), sites.end(), nearer) - sites.begin());
    };
  }
  return [salt = rng(), tiles](const Point& p) {
    std::uint64_t hash = salt;
    for (const double x : {p.x, p.y, p.z})
      hash = finalised_bits(hash ^ finalised_bits(std::bit_cast<std::uint64_t>(x)));
    return static_cast<std::uint32_t>(hash % tiles);
  };
}

class World {
 public:
  World(const ChangeOptions& options, std::uint64_t seed, ChangeReport& report);
  void run();

 private:
  PointIds removed();
  std::vector<LocalPoint> added(const PointIds& removed, bool again);
  std::string change(const Change& change, bool counted);
  std::string compare(const std::vector<IdCell>& expected) const;
  Point at(PointId id) const { return cloud_.at(id); }
  PointId any();

  ChangeReport& report_;
  Rng rng_;
  std::vector<Point> pool_;
  Setting setting_{};
  KnownFromStart around_;
  std::vector<Tile> tile_;
  Cloud cloud_;
  std::vector<PointId> ids_;  // of the cloud
  std::uint64_t next_id_ = 0;
};

constexpr std::size_t points_max = 20;

World::World(const ChangeOptions& options, std::uint64_t seed, ChangeReport& report)
    : report_(report), rng_(finalised_bits(seed + 1)) {
  setting_.options = &options;
  setting_.dimension = 2 + static_cast<int>(rng_() % 2);
  setting_.tiles = 2 + static_cast<std::uint32_t>(rng_() % 7);
  setting_.kernel = rng_() % 6 == 0 ? KernelKind::cgal : KernelKind::flat;
  pool_ =
      universe(setting_.dimension, static_cast<std::size_t>(setting_.dimension) + 2 + rng_() % (points_max + 8), rng_);
  setting_.owner = partition(pool_, setting_.tiles, rng_);
  std::vector<Bounds> bounds(setting_.tiles);
  for (const Point& p : pool_) bounds[setting_.owner(p)].add(p);
  std::vector<std::vector<TileId>> neighbours(setting_.tiles);
  const bool told_bits = rng_() % 4 != 0;
  for (std::uint32_t i = 0; i < setting_.tiles && told_bits; ++i) {
    for (std::uint32_t k = 0; k < setting_.tiles; ++k) {
      if (k != i) neighbours[i].push_back(TileId{k});
    }
  }
  around_ = KnownFromStart(bounds, neighbours, std::vector<Seed>{});
  around_.leave_out_fresh_bit();
  setting_.around = &around_;
  tile_.resize(setting_.tiles);
}

PointId World::any() { return ids_[rng_() % ids_.size()]; }

// One point, any, those of a tile, a ball, the least, a half space, a wall, or a few.
PointIds World::removed() {
  PointIds out;
  const Point center = at(any()), other = at(any());
  const int axis = static_cast<int>(rng_() % static_cast<std::uint64_t>(setting_.dimension));
  const double lo = std::min(center[axis], other[axis]), hi = std::max(center[axis], other[axis]);
  const std::uint64_t way = rng_() % 8, one_in = 2 + rng_() % 4;
  const auto take = [&](const auto& wanted) {
    for (const PointId id : ids_) {
      if (wanted(at(id))) out.insert(id);
    }
  };
  switch (way) {
    case 0:
      take([&](const Point& p) { return p == center; });
      break;
    case 1:
      take([&](const Point&) { return rng_() % one_in == 0; });
      break;
    case 2:
      take([&](const Point& p) { return setting_.owner(p) == setting_.owner(center); });
      break;
    case 3:
      take([&](const Point& p) { return distance(p, center) <= distance(other, center); });
      break;
    case 4:
      take([&](const Point& p) {
        return std::none_of(ids_.begin(), ids_.end(), [&](PointId id) { return at(id) < p; });
      });
      if (rng_() % 2 == 0) out.insert(any());
      break;
    case 5:
      take([&](const Point& p) { return p[axis] <= center[axis]; });
      break;
    case 6:
      take([&](const Point& p) { return lo <= p[axis] && p[axis] <= hi; });
      break;
    default:
      for (std::uint64_t k = 2 + rng_() % 3; k > 0; --k) out.insert(any());
  }
  return out;
}

// One point, those of a tile, a cluster, or any. `again`: some removed points come back under new ids.
std::vector<LocalPoint> World::added(const PointIds& removed, bool again) {
  std::set<Point> inside;
  for (const PointId id : ids_) inside.insert(at(id));
  std::vector<Point> outside;
  for (const Point& p : pool_) {
    if (!inside.contains(p)) outside.push_back(p);
  }
  std::vector<LocalPoint> out;
  if (!outside.empty()) {
    const Point first = outside[rng_() % outside.size()];
    const std::uint64_t way = rng_() % 4;
    std::size_t count = way == 0 ? 1 : 1 + rng_() % outside.size();
    if (way == 1) std::erase_if(outside, [&](const Point& p) { return setting_.owner(p) != setting_.owner(first); });
    if (way == 2) {
      std::sort(outside.begin(), outside.end(),
                [&](const Point& a, const Point& b) { return distance(a, first) < distance(b, first); });
      count = 1 + rng_() % 4;
    } else {
      std::shuffle(outside.begin(), outside.end(), rng_);
    }
    if (way == 1) count = outside.size();
    for (std::size_t k = 0; k < std::min(count, outside.size()) && ids_.size() + k < points_max + 4; ++k) {
      out.push_back({outside[k], PointId{next_id_++}});
    }
  }
  for (const PointId id : removed.sorted()) {
    if (again && rng_() % 2 == 0) out.push_back({at(id), PointId{next_id_++}});
  }
  return out;
}

// Each tile has exactly the cells with a vertex of its own, also a tile that never woke, and exactly their vertices.
std::string World::compare(const std::vector<IdCell>& expected) const {
  const auto corners = static_cast<std::size_t>(setting_.dimension) + 1;
  for (std::uint32_t i = 0; i < setting_.tiles; ++i) {
    std::vector<IdCell> wanted, got;
    std::set<PointId> wanted_foreign, foreign;
    for (const IdCell& cell : expected) {
      const auto own = [&](PointId id) { return setting_.owner(at(id)) == i; };
      if (std::none_of(cell.begin(), cell.begin() + static_cast<std::ptrdiff_t>(corners), own)) continue;
      wanted.push_back(cell);
      for (std::size_t k = 0; k < corners; ++k) {
        if (!own(cell[k])) wanted_foreign.insert(cell[k]);
      }
    }
    if (tile_[i].mesh) {
      const TileMesh& mesh = *tile_[i].mesh;
      for (std::size_t c = 0; c < mesh.cell_ghost.size(); ++c) {
        IdCell cell{infinite_id, infinite_id, infinite_id, infinite_id};
        for (std::size_t k = 0; k < corners; ++k)
          cell[k] = mesh.ids[static_cast<std::size_t>(mesh.cells[c * corners + k])];
        std::sort(cell.begin(), cell.end());
        got.push_back(cell);
      }
      for (std::size_t v = 0; v < mesh.ids.size(); ++v) {
        if (mesh.owners[v].value != i) foreign.insert(mesh.ids[v]);
      }
    }
    std::sort(got.begin(), got.end());
    const std::string what = difference(wanted, got);
    if (!what.empty()) return "tile " + std::to_string(i) + ": " + what;
    if (foreign != wanted_foreign) return "tile " + std::to_string(i) + ": other foreign vertices";
  }
  return "";
}

// Returns what is wrong.
std::string World::change(const Change& change, bool counted) {
  Cloud next;
  std::vector<SharedPoint> stayed;
  for (const auto& [id, p] : cloud_) {
    if (change.removed.contains(id)) continue;
    next[id] = p;
    stayed.push_back({p, id, TileId{setting_.owner(p)}, 0});
  }
  for (const LocalPoint& p : change.added) next[p.id] = p.at;
  std::vector<LocalPoint> points;
  for (const auto& [id, p] : next) points.push_back({p, id});
  const std::vector<IdCell> expected = global_delaunay(points, setting_.dimension);
  if (expected.empty()) {
    ++report_.skipped;
    return "";
  }
  ChangeReport uncounted;
  ChangeReport& report = counted ? report_ : uncounted;
  ++(change.added.empty() ? report.removals : change.removed.empty() ? report.additions : report.both);
  report.tiles += setting_.tiles;
  setting_.seen_before = setting_.removed.size();
  const std::vector<PointId> gone = change.removed.sorted();
  setting_.removed.insert(setting_.removed.end(), gone.begin(), gone.end());
  std::string wrong = Exchange(setting_, tile_, rng_, report).run(change, stayed);
  cloud_ = std::move(next);
  ids_.clear();
  for (const auto& [id, p] : cloud_) ids_.push_back(id);
  return wrong.empty() ? compare(expected) : wrong;
}

// The first result is an addition to nothing.
void World::run() {
  ChangeOptions plain;
  plain.live = setting_.options->live;
  if (plain.live) plain.mutant = setting_.options->mutant;  // live tiles keep their options
  const ChangeOptions* wanted = std::exchange(setting_.options, &plain);
  Change first;
  const auto least = static_cast<std::size_t>(setting_.dimension) + 2;
  const std::size_t count = least + rng_() % (points_max - least);
  for (const Point& p : pool_) {
    if (first.added.size() < count) first.added.push_back({p, PointId{next_id_++}});
  }
  report_.wrong = change(first, false);
  setting_.options = wanted;
  const int changes = setting_.options->live ? 8 : 5;
  for (int k = 0; k < changes && report_.wrong.empty() && !ids_.empty(); ++k) {
    Change next;
    const std::uint64_t kind = rng_() % 3;
    if (kind != 1) next.removed = removed();
    if (kind != 0) next.added = added(next.removed, kind == 2 && rng_() % 3 == 0);
    if (!next.removed.empty() || !next.added.empty()) report_.wrong = change(next, true);
  }
}

}  // namespace

ChangeReport change_worlds(const ChangeOptions& options) {
  ChangeReport report;
  for (std::uint64_t k = 0; k < options.worlds && report.wrong.empty(); ++k) {
    World(options, options.seed + k, report).run();
    if (!report.wrong.empty()) report.wrong = "seed " + std::to_string(options.seed + k) + ": " + report.wrong;
  }
  return report;
}

}  // namespace tessera::testing
