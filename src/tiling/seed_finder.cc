#include "src/tiling/seed_finder.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <map>

#include "src/base/ieee_arithmetic.h"
#include "src/base/mix_hash.h"

namespace tessera {
namespace {

// The reach of a seed, in diagonals of the subtree around the one that the seed represents. A larger reach costs every
// tile more seeds; a smaller one leaves gaps between seeds, which tiles take for empty (docs/benchmarks.md).
constexpr double drawn_reach = 0.7;
constexpr double outermost_reach = 0.5;

constexpr double infinity = std::numeric_limits<double>::infinity();

// The axes and the diagonals between them: 26 directions in space; the first 8 are those of the plane.
constexpr int directions(int dimension) { return dimension == 3 ? 26 : 8; }

constexpr std::array<int, 3> direction(int k) {
  // of the 9 in a layer; the middle one exists only in the other two layers
  const int at = k < 4 ? k : k < 8 ? k + 1 : k - 8;
  const int layer = k < 8 ? 0 : at < 9 ? -1 : 1;
  return {at % 3 - 1, at / 3 % 3 - 1, layer};
}

// As doubles, because every point is compared in all directions.
constexpr auto direction_vectors = [] {
  std::array<Point, directions(3)> vectors{};
  for (int k = 0; k < directions(3); ++k) {
    const auto d = direction(k);
    vectors[static_cast<std::size_t>(k)] = {static_cast<double>(d[0]), static_cast<double>(d[1]),
                                            static_cast<double>(d[2])};
  }
  return vectors;
}();

double along(const Point& p, int k) {
  const Point& d = direction_vectors[static_cast<std::size_t>(k)];
  return p.x * d.x + p.y * d.y + p.z * d.z;
}

double lot(const Point& p) {
  std::uint64_t hash = 0;
  for (int i = 0; i < 3; ++i) hash = MixHash{}(hash + std::bit_cast<std::uint64_t>(p[i]) + 0x9e3779b97f4a7c15u);
  return static_cast<double>(hash >> 11);
}

double diagonal(const Bounds& b) {
  return b.empty() ? 0 : std::hypot(b.hi.x - b.lo.x, b.hi.y - b.lo.y, b.hi.z - b.lo.z);
}

}  // namespace

bool SeedFinder::endless(const Box& box, int k) const {
  const auto d = direction(k);
  for (int i = 0; i < 3; ++i) {
    if (d[i] != 0 && (period_.along(i) || std::isfinite(d[i] > 0 ? box.hi[i] : box.lo[i]))) return false;
  }
  return true;
}

// Of equal keys the first stays. So of equal points the one with the lowest id stays.
void SeedFinder::add(TileId tile, const Box& box, const LocalPoint& p) {
  if (tile.value >= tiles_.size()) tiles_.resize(tile.value + 1);
  Subtree& subtree = tiles_[tile.value];
  const double key = lot(p.at);
  if (subtree.empty) {
    subtree.empty = false;
    subtree.drawn = {key, p};
    for (int k = 0; k < directions(dimension_); ++k) {
      if (endless(box, k)) subtree.outermost.push_back({k, {along(p.at, k), p}});
    }
    return;
  }
  if (key > subtree.drawn.key) subtree.drawn = {key, p};
  for (Outermost& o : subtree.outermost) {
    if (const double a = along(p.at, o.direction); a > o.best.key) o.best = {a, p};
  }
}

void SeedFinder::add(const SeedFinder& next, std::uint64_t first_id) {
  tiles_.resize(std::max(tiles_.size(), next.tiles_.size()));
  const auto take = [&](Candidate& best, const Candidate& other) {
    if (other.key > best.key) best = {other.key, {other.point.at, {other.point.id.value + first_id}}};
  };
  for (std::size_t t = 0; t < next.tiles_.size(); ++t) {
    const Subtree& from = next.tiles_[t];
    Subtree& to = tiles_[t];
    if (from.empty) continue;
    if (to.empty) {  // any candidate has a greater key
      to.empty = false;
      to.drawn.key = -infinity;
      for (const Outermost& o : from.outermost) to.outermost.push_back({o.direction, {-infinity, {}}});
    }
    take(to.drawn, from.drawn);
    const std::size_t directions = std::min(to.outermost.size(), from.outermost.size());
    for (std::size_t i = 0; i < directions; ++i) take(to.outermost[i].best, from.outermost[i].best);
  }
}

void SeedFinder::restart(TileId tile) {
  if (tile.value < tiles_.size()) tiles_[tile.value] = {};
}

void SeedFinder::write(FlatWriter& to) const {
  to.value(static_cast<std::uint64_t>(
      std::count_if(tiles_.begin(), tiles_.end(), [](const Subtree& p) { return !p.empty; })));
  for (std::uint32_t t = 0; t < tiles_.size(); ++t) {
    if (tiles_[t].empty) continue;
    to.value(t);
    to.value(tiles_[t].drawn);
    to.list(tiles_[t].outermost);
  }
}

bool SeedFinder::read(FlatReader& from, std::uint32_t tiles) {
  tiles_.assign(tiles, {});
  std::uint64_t filled = 0;
  if (!from.value(filled)) return false;
  for (std::uint64_t i = 0; i < filled; ++i) {
    std::uint32_t t = 0;
    if (!from.value(t) || t >= tiles || !tiles_[t].empty) return false;
    Subtree& subtree = tiles_[t];
    subtree.empty = false;
    if (!from.value(subtree.drawn) || !from.list(subtree.outermost)) return false;
    int last = -1;
    for (const Outermost& o : subtree.outermost) {
      if (o.direction <= last || o.direction >= directions(dimension_)) return false;
      last = o.direction;
    }
  }
  return true;
}

SeedFinder::Subtree SeedFinder::merged(const Subtree& a, const Subtree& b) const {
  Subtree sum = a.empty ? b : a;
  for (int i = 0; i < 3; ++i) {
    sum.box.lo[i] = std::min(a.box.lo[i], b.box.lo[i]);
    sum.box.hi[i] = std::max(a.box.hi[i], b.box.hi[i]);
  }
  if (a.empty || b.empty) return sum;
  sum.bounds.add(b.bounds);
  const auto better = [](const Candidate& x, const Candidate& y) {
    return x.key > y.key || (x.key == y.key && x.point.id < y.point.id);
  };
  if (better(b.drawn, sum.drawn)) sum.drawn = b.drawn;
  for (const Outermost& o : b.outermost) {
    const auto same = [&](const Outermost& s) { return s.direction == o.direction; };
    const auto found = std::find_if(sum.outermost.begin(), sum.outermost.end(), same);
    if (found == sum.outermost.end()) {
      sum.outermost.push_back(o);
    } else if (better(o.best, found->best)) {
      found->best = o.best;
    }
  }
  return sum;
}

std::vector<Seed> SeedFinder::choose(const Partition& partition, const std::vector<Bounds>& bounds,
                                     std::span<const LocalPoint> everywhere) const {
  std::map<PointId, Seed> found;  // by id
  const auto take = [&](const LocalPoint& p, double reach) {
    Seed& seed = found[p.id];
    seed.point = {p.at, p.id, partition.tile_of(p.at), 0};
    seed.reach = std::max(seed.reach, reach);
  };
  const auto take_outermost = [&](const Subtree& subtree, double reach) {
    for (const Outermost& o : subtree.outermost) {
      if (endless(subtree.box, o.direction)) take(o.best.point, reach);
    }
  };
  const auto tile = [&](std::uint32_t t) {
    Subtree subtree = t < tiles_.size() ? tiles_[t] : Subtree{};
    subtree.bounds = bounds[t];
    subtree.box = partition.boxes()[t];
    return subtree;
  };
  // Recursion, depth first: a tree of 10^6 tiles is at most some hundred levels deep.
  const auto visit = [&](auto&& self, std::int32_t row) -> Subtree {
    if (row < 0) return tile(tile_at(row).value);
    const SplitNode& split = partition.splits()[static_cast<std::size_t>(row)];
    const Subtree below = self(self, split.child[0]), above = self(self, split.child[1]);
    Subtree both = merged(below, above);
    const double size = diagonal(both.bounds);
    for (const Subtree* half : {&below, &above}) {
      if (half->empty) continue;
      take(half->drawn.point, drawn_reach * size);
      take_outermost(*half, outermost_reach * size);
    }
    return both;
  };
  for (const LocalPoint& p : everywhere) take(p, infinity);
  if (!partition.splits().empty()) {
    const Subtree all = visit(visit, 0);
    take(all.drawn.point, infinity);
    take_outermost(all, infinity);
  } else if (partition.tiles() > 1) {  // without splits all tiles are one in another, so all are near
    Subtree all;
    for (std::uint32_t t = 0; t < partition.tiles(); ++t) {
      const Subtree subtree = tile(t);
      if (!subtree.empty) take(subtree.drawn.point, infinity);
      all = merged(all, subtree);
    }
    take_outermost(all, infinity);
  }
  std::vector<Seed> seeds;
  seeds.reserve(found.size());
  for (const auto& [id, seed] : found) seeds.push_back(seed);
  const auto by_tile = [](const Seed& a, const Seed& b) { return a.point.tile < b.point.tile; };
  std::stable_sort(seeds.begin(), seeds.end(), by_tile);
  return seeds;
}

}  // namespace tessera
