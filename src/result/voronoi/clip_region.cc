#include "src/result/voronoi/clip_region.h"

#include <bit>

#include "src/geometry/predicates/exact/predicates.h"
#include "src/result/voronoi/corner_order.h"
#include "src/result/voronoi/exact_number.h"

namespace tessera::voronoi {

namespace {

// Whether p, which is on the line of the edge, is strictly between its ends.
bool between(const Point& p, const ClipRegion::Edge& edge) {
  return before(edge.a, edge.b) ? before(edge.a, p) && before(p, edge.b) : before(edge.b, p) && before(p, edge.a);
}

bool cross_or_touch(const ClipRegion::Edge& e, const ClipRegion::Edge& f) {
  const int fa = exact::orientation_2(e.a, e.b, f.a), fb = exact::orientation_2(e.a, e.b, f.b);
  const int ea = exact::orientation_2(f.a, f.b, e.a), eb = exact::orientation_2(f.a, f.b, e.b);
  if (fa * fb < 0 && ea * eb < 0) return true;
  return (fa == 0 && between(f.a, e)) || (fb == 0 && between(f.b, e)) || (ea == 0 && between(e.a, f)) ||
         (eb == 0 && between(e.b, f));
}

bool meet(const Bounds& a, const Bounds& b) {
  return a.lo.x <= b.hi.x && b.lo.x <= a.hi.x && a.lo.y <= b.hi.y && b.lo.y <= a.hi.y;
}

}  // namespace

bool has_odd(std::vector<std::uint32_t>& polygons) {
  std::sort(polygons.begin(), polygons.end());
  for (std::size_t i = 0, end = 0; i < polygons.size(); i = end) {
    while (end < polygons.size() && polygons[end] == polygons[i]) ++end;
    if ((end - i) % 2 == 1) return true;
  }
  return false;
}

Bounds ClipRegion::box_of(const Edge& edge) {
  Bounds box;
  box.add(edge.a);
  box.add(edge.b);
  return box;
}

void ClipRegion::add(std::span<const std::vector<Point>> rings) {
  for (const auto& ring : rings)
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Point &a = ring[i], &b = ring[(i + 1) % ring.size()];
      if (!same(a, b)) edges_.push_back({{a.x, a.y, 0}, {b.x, b.y, 0}, polygons_});
    }
  ++polygons_;
}

void ClipRegion::index() {
  exponent_ = no_exponent;
  for (const Edge& edge : edges_) {
    bounds_.add(edge.a);
    bounds_.add(edge.b);
    exponent_ = std::min({exponent_, exponent_of(edge.a.x), exponent_of(edge.a.y)});
    exponent_ = std::min({exponent_, exponent_of(edge.b.x), exponent_of(edge.b.y)});
  }
  leaves_ = std::bit_ceil(std::max<std::size_t>((edges_.size() + edges_of_leaf - 1) / edges_of_leaf, 1));
  boxes_.assign(2 * leaves_, Bounds{});
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    boxes_[leaves_ + i / edges_of_leaf].add(edges_[i].a);
    boxes_[leaves_ + i / edges_of_leaf].add(edges_[i].b);
  }
  for (std::size_t node = leaves_; node-- > 1;) {
    for (const Bounds& child : {boxes_[2 * node], boxes_[2 * node + 1]}) {
      if (!(child.lo.x <= child.hi.x)) continue;
      boxes_[node].add(child.lo);
      boxes_[node].add(child.hi);
    }
  }
  if (!one_part_) find_crossings();
}

void ClipRegion::find_crossings() {
  for (std::uint32_t i = 0; i < edges_.size(); ++i) {
    const Bounds own = box_of(edges_[i]);
    visit([&](const Bounds& box) { return meet(box, own); },
          [&](std::uint32_t other) {
            if (other != i && cross_or_touch(edges_[i], edges_[other])) pairs_.emplace_back(i, other);
          });
  }
  std::sort(pairs_.begin(), pairs_.end());
  for (const auto& pair : pairs_) crossed_.push_back(pair.second);
}

std::span<const std::uint32_t> ClipRegion::crossing(std::uint32_t edge) const {
  const auto first = std::lower_bound(pairs_.begin(), pairs_.end(), std::pair(edge, std::uint32_t{0}));
  const auto end = std::lower_bound(first, pairs_.end(), std::pair(edge + 1, std::uint32_t{0}));
  return std::span(crossed_).subspan(static_cast<std::size_t>(first - pairs_.begin()),
                                     static_cast<std::size_t>(end - first));
}

bool ClipRegion::contains(const Point& p) const {
  std::vector<std::uint32_t> met;
  visit([&](const Bounds& box) { return box.lo.y <= p.y && p.y <= box.hi.y && p.x <= box.hi.x; },
        [&](std::uint32_t i) {
          const Edge& edge = edges_[i];
          const bool up = edge.a.y < edge.b.y;
          const Point &low = up ? edge.a : edge.b, &high = up ? edge.b : edge.a;
          // Half-open in y, so that a ray through a vertex crosses one of its two edges, or none, or both.
          if (low.y <= p.y && p.y < high.y && exact::orientation_2(low, high, p) > 0) met.push_back(edge.polygon);
        });
  return has_odd(met);
}

bool ClipRegion::covers(const Point& p) const {
  bool on_edge = false;
  visit([&](const Bounds& box) { return box.lo.x <= p.x && p.x <= box.hi.x && box.lo.y <= p.y && p.y <= box.hi.y; },
        [&](std::uint32_t i) { on_edge = on_edge || exact::orientation_2(edges_[i].a, edges_[i].b, p) == 0; });
  return on_edge || contains(p);
}

}  // namespace tessera::voronoi
