#include "src/result/query/area.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "src/base/ledger.h"
#include "src/geometry/predicates/exact/predicates.h"
#include "src/result/query/geojson.h"

namespace tessera::query {
namespace {

// True if a line or plane through a facet of the cell has the whole box strictly on the other side.
bool facet_separates(std::span<const Point> cell, const Bounds& box) {
  const std::size_t corners = cell.size(), d = corners - 1;
  std::array<Point, 4> p;
  std::copy(cell.begin(), cell.end(), p.begin());
  for (std::size_t k = 0; k < corners; ++k) {
    const Point kept = p[k];
    bool apart = true;
    for (unsigned corner = 0; apart && corner < (1u << d); ++corner) {
      for (std::size_t axis = 0; axis < d; ++axis)
        p[k][static_cast<int>(axis)] =
            (corner >> axis & 1u) != 0 ? box.hi[static_cast<int>(axis)] : box.lo[static_cast<int>(axis)];
      apart = (d == 3 ? exact::orientation_3(p[0], p[1], p[2], p[3]) : exact::orientation_2(p[0], p[1], p[2])) < 0;
    }
    if (apart) return true;
    p[k] = kept;
  }
  return false;
}

// The same for planes through an edge of the tetrahedron and parallel to an edge of the box, which is parallel to an
// axis. In the projection along the axis, this is a line through two vertices that has the others on one side, or on
// the line, and the rectangle strictly on the other side.
bool edges_separate(std::span<const Point> cell, const Bounds& box) {
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    const auto flat = [&](const Point& p) { return Point{p[u], p[v], 0}; };
    std::array<Point, 4> p;
    for (std::size_t k = 0; k < 4; ++k) p[k] = flat(cell[k]);
    const std::array<Point, 4> rectangle{Point{box.lo[u], box.lo[v], 0}, Point{box.lo[u], box.hi[v], 0},
                                         Point{box.hi[u], box.lo[v], 0}, Point{box.hi[u], box.hi[v], 0}};
    for (std::size_t a = 0; a < 4; ++a) {
      for (std::size_t b = a + 1; b < 4; ++b) {
        for (const int side : {-1, 1}) {
          bool apart = true;
          for (const Point& r : rectangle) apart = apart && exact::orientation_2(p[a], p[b], r) == side;
          for (std::size_t c = 0; c < 4; ++c)
            apart = apart && (c == a || c == b || exact::orientation_2(p[a], p[b], p[c]) != side);
          if (apart) return true;
        }
      }
    }
  }
  return false;
}

bool on_segment(const Point& p, const Point& a, const Point& b) {
  return exact::orientation_2(a, b, p) == 0 && std::min(a.x, b.x) <= p.x && p.x <= std::max(a.x, b.x) &&
         std::min(a.y, b.y) <= p.y && p.y <= std::max(a.y, b.y);
}

// Decides for closed segments, which may be points.
bool segments_meet(const Point& a, const Point& b, const Point& c, const Point& d) {
  if (std::max(a.x, b.x) < std::min(c.x, d.x) || std::max(c.x, d.x) < std::min(a.x, b.x) ||
      std::max(a.y, b.y) < std::min(c.y, d.y) || std::max(c.y, d.y) < std::min(a.y, b.y))
    return false;
  const int c_side = exact::orientation_2(a, b, c), d_side = exact::orientation_2(a, b, d);
  const int a_side = exact::orientation_2(c, d, a), b_side = exact::orientation_2(c, d, b);
  if (c_side * d_side < 0 && a_side * b_side < 0) return true;
  return on_segment(c, a, b) || on_segment(d, a, b) || on_segment(a, c, d) || on_segment(b, c, d);
}

// True if p is strictly inside the triangle, whatever its orientation; a flat triangle has no inside.
bool inside_triangle(const Point& p, const Point& a, const Point& b, const Point& c) {
  const int side = exact::orientation_2(a, b, p);
  return side != 0 && side == exact::orientation_2(b, c, p) && side == exact::orientation_2(c, a, p);
}

// The most strips that an edge of a polygon meets on average.
constexpr std::uint64_t met_of_edge = 8;

Status check_edges(const std::vector<std::vector<Point>>& rings) {
  std::uint64_t edges = 0;
  for (const auto& ring : rings) edges += ring.size();
  constexpr std::uint64_t edges_max = std::uint64_t{1} << 28;
  if (edges >= edges_max)
    return error(Errc::memory, "the polygon has " + std::to_string(edges) + " edges, but may have fewer than " +
                                   std::to_string(edges_max));
  return Ledger::draw_memory(edges * Polygon::bytes_of_edge);
}

}  // namespace

// Two convex sets in the plane are disjoint if and only if a line along a side of one of them separates them.
bool meets(std::span<const Point> cell, const Leg& leg) {
  int left = 0, right = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const Point &a = cell[k], &b = cell[k == 2 ? 0 : k + 1];
    if (exact::orientation_2(a, b, leg.from) < 0 && exact::orientation_2(a, b, leg.to) < 0) return false;
    const int side = exact::orientation_2(leg.from, leg.to, a);
    left += side > 0 ? 1 : 0;
    right += side < 0 ? 1 : 0;
  }
  return left < 3 && right < 3;
}

bool meets(std::span<const Point> cell, const Bounds& box) {
  for (int axis = 0; axis + 1 < static_cast<int>(cell.size()); ++axis) {
    const auto [least, most] = std::minmax_element(
        cell.begin(), cell.end(), [axis](const Point& a, const Point& b) { return a[axis] < b[axis]; });
    if ((*most)[axis] < box.lo[axis] || box.hi[axis] < (*least)[axis]) return false;
  }
  return !facet_separates(cell, box) && (cell.size() == 3 || !edges_separate(cell, box));
}

Result<Polygon> Polygon::of_shapes(GeoJsonShapes shapes) {
  BOOST_OUTCOME_TRYV(check_edges(shapes.lists));
  Polygon polygon(std::move(shapes.lists));
  polygon.place_ = std::move(shapes.place);
  return polygon;
}

Result<Polygon> Polygon::read_geojson(const std::filesystem::path& path) {
  BOOST_OUTCOME_TRY(shapes, query::read_geojson(path, GeoJson::polygons));
  return of_shapes(std::move(shapes));
}

Result<Polygon> Polygon::of_geojson(std::string_view text, const std::string& name) {
  BOOST_OUTCOME_TRY(shapes, query::of_geojson(text, name, GeoJson::polygons));
  return of_shapes(std::move(shapes));
}

Polygon::Polygon(std::vector<std::vector<Point>> rings) {
  std::size_t edges = 0;
  for (const auto& ring : rings) edges += ring.size();
  edges_.reserve(edges);
  for (const auto& ring : rings) {
    for (const Point& p : ring) bounds_.add(p);
    for (std::size_t i = 0; i < ring.size(); ++i) {
      Edge edge{ring[i], ring[(i + 1) % ring.size()]};
      if (edge.a.y > edge.b.y) std::swap(edge.a, edge.b);
      edges_.push_back(edge);
    }
  }
  // Edges that are long in y meet many strips. The number of strips is reduced until an edge meets only a few on
  // average. If all edges are as high as the polygon, y does not tell them apart anyway.
  const std::uint64_t met_max = edges_.size() * met_of_edge;
  std::size_t strips = std::clamp<std::size_t>(edges_.size() / 4, 1, 4096);
  while (index_strips(strips) > met_max) strips /= 2;
  met_.resize(begin_.back());
  auto next = begin_;
  for (std::uint32_t i = 0; i < edges_.size(); ++i)
    for (std::size_t s = strip(edges_[i].a.y); s <= strip(edges_[i].b.y); ++s) met_[next[s]++] = i;
}

// Sets where the edges of each of so many strips begin. Returns the number of entries in all strips.
std::uint64_t Polygon::index_strips(std::size_t strips) {
  begin_.assign(strips + 1, 0);
  // First, the change of the number of edges from one strip to the next: plus one where an edge begins, minus one after
  // it ends.
  std::vector<std::int64_t> change(strips + 1);
  for (const Edge& edge : edges_) {
    ++change[strip(edge.a.y)];
    --change[strip(edge.b.y) + 1];
  }
  std::int64_t here = 0;
  std::uint64_t sum = 0;
  for (std::size_t s = 0; s < strips; ++s) {
    begin_[s] = static_cast<std::uint32_t>(sum);
    here += change[s];
    sum += static_cast<std::uint64_t>(here);
  }
  begin_[strips] = static_cast<std::uint32_t>(sum);
  return sum;
}

// Rounding does no harm: it is monotone, so the lower of two numbers never gets the higher strip.
std::size_t Polygon::strip(double y) const {
  const double part = (y - bounds_.lo.y) / (bounds_.hi.y - bounds_.lo.y) * static_cast<double>(strips());
  if (!(part > 0)) return 0;
  return std::min(static_cast<std::size_t>(std::min(part, 1e6)), strips() - 1);
}

bool Polygon::contains(const Point& p) const {
  if (p.y < bounds_.lo.y || bounds_.hi.y < p.y) return false;
  bool inside = false;
  for (const std::uint32_t i : edges_in(strip(p.y))) {
    const Edge& edge = edges_[i];
    if (on_segment(p, edge.a, edge.b)) return true;
    // Half-open in y, so that a ray through a vertex crosses one of its two edges, or none, or both.
    if (edge.a.y <= p.y && p.y < edge.b.y && exact::orientation_2(edge.a, edge.b, p) > 0) inside = !inside;
  }
  return inside;
}

bool Polygon::meets_triangle(const Point& a, const Point& b, const Point& c) const {
  if (contains(a)) return true;  // or a ring passes between the triangle's points
  const auto [low, high] = std::minmax({a.y, b.y, c.y});
  if (high < bounds_.lo.y || bounds_.hi.y < low) return false;
  for (std::size_t s = strip(low); s <= strip(high); ++s) {
    for (const std::uint32_t i : edges_in(s)) {
      const Edge& e = edges_[i];
      if (segments_meet(e.a, e.b, a, b) || segments_meet(e.a, e.b, b, c) || segments_meet(e.a, e.b, c, a) ||
          inside_triangle(e.a, a, b, c))
        return true;
    }
  }
  return false;
}

bool Polygon::meets(std::span<const Point> cell) const {
  const auto flat = [&](std::size_t k) { return Point{cell[k].x, cell[k].y, 0}; };
  if (cell.size() == 3) return meets_triangle(flat(0), flat(1), flat(2));
  // The projection of a tetrahedron is the union of the projections of its facets.
  for (std::size_t k = 0; k < 4; ++k)
    if (meets_triangle(flat(k == 0 ? 3 : 0), flat(k == 1 ? 3 : 1), flat(k == 2 ? 3 : 2))) return true;
  return false;
}

}  // namespace tessera::query
