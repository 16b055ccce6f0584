#include "src/result/voronoi/repairs.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

#include "src/result/voronoi/corner_order.h"

namespace tessera::voronoi {

namespace {

auto key_of(const Insertion& i) { return std::tuple(i.a.x, i.a.y, i.b.x, i.b.y, i.corner.x, i.corner.y); }
bool less(const Insertion& a, const Insertion& b) { return key_of(a) < key_of(b); }

Insertion make_insertion(const Point& a, const Point& b, const Point& corner) {
  return before(a, b) ? Insertion{a, b, corner} : Insertion{b, a, corner};
}

// The distance of a point from a side, if the point is beside it and is none of its ends.
std::optional<long double> distance(const Point& p, const Point& a, const Point& b) {
  if (same(p, a) || same(p, b)) return std::nullopt;
  const long double x = static_cast<long double>(b.x) - a.x, y = static_cast<long double>(b.y) - a.y;
  const long double px = static_cast<long double>(p.x) - a.x, py = static_cast<long double>(p.y) - a.y;
  const long double square = x * x + y * y, along = px * x + py * y;
  if (!(along > 0 && along < square)) return std::nullopt;
  return std::abs(px * y - py * x) / std::sqrt(square);
}

struct NearCorner {
  std::optional<Insertion> insertion;
  long double distance = 0;
  void take(const Point& p, const Point& a, const Point& b) {
    const auto found = voronoi::distance(p, a, b);
    if (!found || (insertion && !(*found < distance))) return;
    insertion = make_insertion(a, b, p);
    distance = *found;
  }
};

// The corner that is nearest to the longest side of the ring.
std::optional<Insertion> of_longest_side(const Ring& ring) {
  std::size_t longest = 0;
  long double most = -1;
  const auto next = [&](std::size_t i) -> const Point& { return ring[(i + 1) % ring.size()]; };
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const long double length =
        std::hypot(static_cast<long double>(next(i).x) - ring[i].x, static_cast<long double>(next(i).y) - ring[i].y);
    if (length > most) longest = i;
    most = std::max(most, length);
  }
  NearCorner nearest;
  for (const Point& p : ring) nearest.take(p, ring[longest], next(longest));
  return nearest.insertion;
}

}  // namespace

std::optional<Insertion> find_insertion(std::span<const Ring> part) {
  if (const auto clash = find_clash(part)) {
    NearCorner nearest;
    for (const auto& [e, f] : {std::pair(clash->first, clash->second), std::pair(clash->second, clash->first)})
      for (const Point& p : {f.a, f.b}) nearest.take(p, e.a, e.b);
    return nearest.insertion;
  }
  for (std::size_t r = 0; r < part.size(); ++r)
    if (part[r].size() >= 3 && runs_counterclockwise(part[r]) != (r == 0)) return of_longest_side(part[r]);
  return std::nullopt;
}

bool insert(CellShape& shape, std::span<const Insertion> sorted) {
  bool any = false;
  for (auto& part : shape.parts) {
    for (Ring& ring : part) {
      // A bound, should insertions contradict each other.
      const std::size_t most = 4 * ring.size() + 64;
      for (std::size_t i = 0; i < ring.size() && ring.size() < most; ++i) {
        const Point a = ring[i], b = ring[(i + 1) % ring.size()];
        const Insertion wanted = make_insertion(a, b, {});
        const auto same_side = [&](const Insertion& x) { return same(x.a, wanted.a) && same(x.b, wanted.b); };
        auto at = std::lower_bound(sorted.begin(), sorted.end(), wanted, [](const Insertion& x, const Insertion& y) {
          return std::tuple(x.a.x, x.a.y, x.b.x, x.b.y) < std::tuple(y.a.x, y.a.y, y.b.x, y.b.y);
        });
        std::vector<Point> corners;
        for (; at != sorted.end() && same_side(*at); ++at) corners.push_back(at->corner);
        if (corners.empty()) continue;
        std::sort(corners.begin(), corners.end(), [&](const Point& p, const Point& q) {
          const auto along = [&](const Point& c) {
            return (static_cast<long double>(c.x) - a.x) * (static_cast<long double>(b.x) - a.x) +
                   (static_cast<long double>(c.y) - a.y) * (static_cast<long double>(b.y) - a.y);
          };
          return along(p) < along(q);
        });
        ring.insert(ring.begin() + static_cast<std::ptrdiff_t>(i + 1), corners.begin(), corners.end());
        any = true;
        --i;  // the first piece of the side may have insertions of its own
      }
    }
  }
  return any;
}

namespace {

// The rings into which a ring falls at corners that it visits twice.
std::vector<Ring> simple_rings(const Ring& ring) {
  std::vector<Ring> found;
  Ring open;
  std::map<std::pair<double, double>, std::size_t> place;
  for (const Point& p : ring) {
    const std::pair key(p.x, p.y);
    if (const auto at = place.find(key); at != place.end()) {
      const std::size_t first = at->second;
      if (open.size() - first > 2) found.emplace_back(open.begin() + static_cast<std::ptrdiff_t>(first), open.end());
      for (std::size_t i = first; i < open.size(); ++i) place.erase({open[i].x, open[i].y});
      open.resize(first);
    }
    place[key] = open.size();
    open.push_back(p);
  }
  if (open.size() > 2) found.push_back(std::move(open));
  return found;
}

}  // namespace

void clean(CellShape& shape) {
  std::vector<std::vector<Ring>> parts;
  for (auto& part : shape.parts) {
    std::vector<Ring> holes;
    const std::size_t first = parts.size();
    for (std::size_t r = 0; r < part.size(); ++r) {
      for (Ring& ring : simple_rings(part[r])) {
        begin_with_least(ring);
        if (r == 0) {
          parts.push_back({std::move(ring)});
        } else {
          holes.push_back(std::move(ring));
        }
      }
    }
    for (Ring& hole : holes)
      if (first < parts.size()) parts[first].push_back(std::move(hole));
  }
  shape.parts = std::move(parts);
}

bool Repairs::repair(const std::vector<Ring>& part) {
  constexpr int rounds = 64;
  std::vector<Insertion> found;
  CellShape shape{{part}};
  for (int round = 0; round < rounds; ++round) {
    const auto bad = std::find_if(shape.parts.begin(), shape.parts.end(), [](const auto& p) { return !is_valid(p); });
    if (bad == shape.parts.end()) {
      const std::lock_guard lock(mutex_);
      all_.insert(all_.end(), found.begin(), found.end());
      return true;
    }
    const auto next = find_insertion(*bad);
    if (!next) return false;
    found.push_back(*next);
    if (!insert(shape, std::span(&found.back(), 1))) return false;
    clean(shape);
  }
  return false;
}

void Repairs::finish() {
  std::sort(all_.begin(), all_.end(), less);
  all_.erase(std::unique(all_.begin(), all_.end(), [](const auto& a, const auto& b) { return key_of(a) == key_of(b); }),
             all_.end());
}

bool Repairs::apply(CellShape& shape) const {
  if (all_.empty() || !insert(shape, all_)) return false;
  clean(shape);
  return true;
}

}  // namespace tessera::voronoi
