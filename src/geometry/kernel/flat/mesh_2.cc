#include "src/geometry/kernel/flat/mesh_2.h"

#include <algorithm>
#include <cmath>

#include "src/base/check.h"
#include "src/geometry/kernel/flat/mesh_impl.h"
#include "src/geometry/kernel/flat/remove_impl.h"
#include "src/geometry/kernel/flat/walk_impl.h"
#include "src/geometry/predicates/exact/predicates.h"

namespace tessera::flat2 {

Vertex Mesh::add(const Point& p) {
  points.own();
  return points.add(p);
}

bool Mesh::spans_more(const Point& p) const {
  if (spanned_ < 1) return spanned_ < 0 || !flat::same_place<2>(corner(0), p);
  return exact::orientation_2(corner(0), corner(1), p) != 0;
}

bool Mesh::positive(const Corners& v) const { return exact::orientation_2(point(v[0]), point(v[1]), point(v[2])) > 0; }

bool Mesh::conflicts_with_hull(const Point& p, const Cell& t) const {
  const Index i = t.v[1] == infinite_vertex ? 1 : 2;
  const Point &a = point(t.v[next_of[i]]), &b = point(t.v[before[i]]);
  if (const int side = exact::orientation_2(a, b, p); side != 0) return side > 0;
  // On the line of a hull edge a point is in conflict strictly between the ends of the edge.
  const bool by_x = a.x != b.x;
  const double from = by_x ? a.x : a.y, to = by_x ? b.x : b.y, at = by_x ? p.x : p.y;
  return (from < at && at < to) || (to < at && at < from);
}

bool Mesh::conflicts(const Point& p, Index slot) const {
  const Cell& t = cells[slot];
  if (t.infinite()) [[unlikely]]
    return conflicts_with_hull(p, t);
  return exact::in_circle_perturbed_2(point(t.v[0]), point(t.v[1]), point(t.v[2]), p) > 0;
}

// Point location is a visibility walk that starts at the last insertion. The walk ends, because the triangulation is
// Delaunay (De Floriani, Falcidieno, Nagy, Pienovi 1991). Returns false if frozen triangles block every side that faces
// p.
bool Mesh::walk(const Point& p, Index slot, Located& found) const {
  const Cell* const all = cells.data();
  if (all[slot].infinite()) {
    const Index inside = all[slot].n[all[slot].v[1] == infinite_vertex ? 1 : 2];
    if (inside & frozen_bit) return false;
    slot = inside >> 2;
  }
  Index from = 0;
  if (const Cell& t = all[slot]; exact::orientation_2(point(t.v[1]), point(t.v[2]), p) < 0) {
    if (t.n[0] & frozen_bit) return false;
    slot = t.n[0] >> 2;
    from = t.n[0] & 3;
  }
  // p is on the inner side of edge `from`. The edge goes from r to l; both are relative to p.
  struct Vector {
    double x, y;
  };
  const auto relative = [&](Vertex v) { return Vector{point(v).x - p.x, point(v).y - p.y}; };
  Vector r = relative(all[slot].v[next_of[from]]), l = relative(all[slot].v[before[from]]);
  while (true) {
    const Cell& t = all[slot];
    if (t.v[from] == infinite_vertex) {  // p is strictly outside the hull
      found = {slot, 0};
      return true;
    }
    const Vector c = relative(t.v[from]);
    // Both other edges are asked at once, and the next triangle is chosen without a branch, because the processor
    // cannot predict it. The error bound is that of exact::filter::orientation_2.
    const double l1 = l.x * c.y, l2 = l.y * c.x, r1 = c.x * r.y, r2 = c.y * r.x;
    const double l_side = l1 - l2, r_side = r1 - r2;  // where p is at the edge from l to c, and at that from c to r
    constexpr double u = exact::filter::u, underflow = exact::filter::underflow;
    const bool l_certain = std::abs(l_side) > 5 * u * (std::abs(l1) + std::abs(l2)) + underflow;
    const bool r_certain = std::abs(r_side) > 5 * u * (std::abs(r1) + std::abs(r2)) + underflow;
    bool across_l = l_side < 0, across_r = r_side < 0;
    if (!(l_certain & r_certain)) [[unlikely]] {
      if (c.x == 0 && c.y == 0) {
        found = {slot, t.v[from]};
        return true;
      }
      across_l = exact::orientation_2(point(t.v[before[from]]), point(t.v[from]), p) < 0;
      across_r = exact::orientation_2(point(t.v[from]), point(t.v[next_of[from]]), p) < 0;
    }
    if (!(across_l | across_r)) {
      found = {slot, 0};
      for (const Vertex v : t.v) {
        if (flat::same_place<2>(point(v), p)) found.same = v;
      }
      return true;
    }
    const Index next_l = t.n[next_of[from]], next_r = t.n[before[from]];
    if (((across_l ? next_l : 0) | (across_r ? next_r : 0)) & frozen_bit) [[unlikely]] {
      across_l &= !(next_l & frozen_bit);
      across_r &= !(next_r & frozen_bit);
      if (!(across_l | across_r)) return false;
    }
    // Seen from the next triangle, c begins the edge to l, or ends the edge from r.
    const Index across = across_l ? next_l : next_r;
    l = across_l ? l : c;
    r = across_l ? c : r;
    slot = across >> 2;
    from = across & 3;
  }
}

// In 2D a conflict zone has no vertex inside. So its triangles and their common edges form a tree, and no triangle is
// met twice. Going through the tree depth first, counterclockwise, gives the boundary in order. Both edges of a
// triangle are asked before either answer is used: the processor cannot predict the answers, and so it waits for both
// at once.
void Mesh::find_zone(const Point& query, Index start) {
  const Point p = query;
  before_zone();
  const Cell* const all = cells.data();
  const Point* const at = points.first();
  if (near_.size() < 64) near_.resize(64), pending_.resize(64), boundary_.resize(64), zone_.resize(64);
  Near* near = near_.data();
  Pending* pending = pending_.data();
  Index near_size = 0;
  std::size_t size = 0, zone_size = 0, boundary_size = 0;

  const auto add_near = [&](Vertex v) {
    Near& c = near[near_size++];
    c.v = v;
    if (v == infinite_vertex) [[unlikely]]
      return;
    const double x = at[v].x - p.x, y = at[v].y - p.y;
    c.x = x, c.y = y, c.lift = x * x + y * y;
  };
  // Puts the edge from a to b on the stack, and computes whether the triangle across it is in conflict.
  const auto ask = [&](Index across, Index a_index, Index b_index) __attribute__((always_inline)) {
    Pending& edge = pending[size++];
    edge.across = across, edge.a = a_index, edge.b = b_index, edge.c = near_size;
    if (across & frozen_bit) [[unlikely]] {
      edge.in_conflict = false;
      return;
    }
    const Cell& t = all[across >> 2];  // t has the corners c, b, a
    const Near &a = near[a_index], &b = near[b_index], &c = near[near_size];
    add_near(t.v[across & 3]);
    if (c.v == infinite_vertex || a.v == infinite_vertex || b.v == infinite_vertex) [[unlikely]] {
      edge.in_conflict = conflicts_with_hull(p, t);
      return;
    }
    // The filter is exact::filter::in_circle_2 with the largest lift in place of the product of the largest x and y.
    const double det =
        a.lift * (c.x * b.y - b.x * c.y) + c.lift * (b.x * a.y - a.x * b.y) + b.lift * (a.x * c.y - c.x * a.y);
    const double lift = std::max(std::max(a.lift, b.lift), c.lift);
    const double error = 70 * exact::filter::u * (lift * lift) + exact::filter::underflow;
    if (std::abs(det) > error && lift < exact::filter::lift_max) [[likely]] {
      edge.in_conflict = det > 0;
    } else {
      edge.in_conflict = exact::in_circle_perturbed_2(point(t.v[0]), point(t.v[1]), point(t.v[2]), p) > 0;
    }
  };

  zone_[zone_size++] = start;
  const Cell& first = all[start];
  for (const Vertex v : first.v) add_near(v);
  ask(first.n[1], 2, 0);
  ask(first.n[0], 1, 2);
  ask(first.n[2], 0, 1);
  while (size > 0) {
    const Pending& edge = pending[--size];
    const Index across = edge.across, a = edge.a, b = edge.b, c = edge.c;  // read one by one, as they were just stored
    if (!edge.in_conflict) {
      boundary_[boundary_size++] = {across, near[a].v};
      continue;
    }
    const Index slot = across >> 2, i = across & 3;
    zone_[zone_size++] = slot;
    if (near_size + 4 > near_.size()) [[unlikely]] {  // the size of near_ bounds the sizes of the other arrays
      const std::size_t n = 2 * near_.size();
      near_.resize(n), pending_.resize(n), boundary_.resize(n), zone_.resize(n);
      near = near_.data(), pending = pending_.data();
    }
    const Cell& t = all[slot];
    ask(t.n[before[i]], c, b);
    ask(t.n[next_of[i]], a, c);
  }
  zone_size_ = zone_size;
  boundary_size_ = boundary_size;
  after_zone(zone_size);
}

// A boundary of k edges encloses k - 2 triangles. The fill has k triangles: (v, from, from of the next edge).
void Mesh::fill(Vertex v) {
  const std::size_t k = boundary_size_;
  zone_[k - 2] = new_slot();
  zone_[k - 1] = new_slot();
  Cell* const all = cells.data();
  const Index* const slots = zone_.data();
  const Edge* const edges = boundary_.data();
  Index previous = slots[k - 1], slot = slots[0];
  Vertex from = edges[0].from;
  for (std::size_t e = 0; e < k; ++e) {
    const std::size_t after = e + 1 < k ? e + 1 : 0;
    const Index across = edges[e].across, next = slots[after];
    const Vertex to = edges[after].from;
    Cell& t = all[slot];
    t.v[0] = v, t.v[1] = from, t.v[2] = to;
    t.state = State::plain;
    t.n[0] = across, t.n[1] = 4 * next + 2, t.n[2] = 4 * previous + 1;
    if (!(across & frozen_bit)) [[likely]]
      all[across >> 2].n[across & 3] = 4 * slot;
    previous = slot, slot = next, from = to;
  }
  last_ = slots[k - 1];
}

void Mesh::around(Vertex v, std::vector<Index>& found) const {
  found.clear();
  const Index first = incident(v);
  Index slot = first;
  do {
    const Cell& t = cells[slot];
    found.push_back(slot);
    const Index i = t.v[0] == v ? 0 : t.v[1] == v ? 1 : 2;
    const Index across = t.n[next_of[i]];
    check_read(!(across & frozen_bit), "a triangle around a vertex is frozen");
    slot = across >> 2;
  } while (slot != first);
}

// Each triangle around v adds one neighbour: the vertex opposite the edge across which the next triangle lies.
void Mesh::neighbours_into(Vertex v, std::vector<Vertex>& vertices) const {
  const Index first = incident(v);
  Index slot = first;
  do {
    const Cell& t = cells[slot];
    const Index i = t.v[0] == v ? 0 : t.v[1] == v ? 1 : 2;
    if (t.v[next_of[i]] != infinite_vertex) vertices.push_back(t.v[next_of[i]]);
    const Index across = t.n[next_of[i]];
    check_read(!(across & frozen_bit), "a triangle around a vertex is frozen");
    slot = across >> 2;
  } while (slot != first);
}

void Mesh::release_scratch() {
  zone_size_ = boundary_size_ = 0;
  flat::release(zone_, boundary_, pending_, near_);
}

void Mesh::zone_into(std::vector<Vertex>& vertices) const {
  for (std::size_t k = 0; k < boundary_size_; ++k) {
    if (boundary_[k].from != infinite_vertex) vertices.push_back(boundary_[k].from);
  }
}

std::size_t Mesh::memory() const {
  return base_memory() + zone_.capacity() * sizeof(Index) + boundary_.capacity() * sizeof(Edge) +
         pending_.capacity() * sizeof(Pending) + near_.capacity() * sizeof(Near);
}

}  // namespace tessera::flat2

template class tessera::flat::MeshBase<tessera::flat2::Mesh, tessera::flat2::Cell>;
