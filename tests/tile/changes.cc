#include "tests/tile/changes.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "src/base/check.h"
#include "src/base/mixed_bits.h"
#include "src/geometry/reference/clouds.h"
#include "src/geometry/reference/reference.h"
#include "tests/tile/changed_exchange.h"

namespace tessera::testing {
namespace {

using namespace changed;
using Cloud = std::map<PointId, Point>;

double distance(const Point& a, const Point& b) { return std::hypot(a.x - b.x, a.y - b.y, a.z - b.z); }

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
