// Point location in 2D: a visibility walk that starts at the last insertion. The walk ends, because the triangulation
// is Delaunay (De Floriani, Falcidieno, Nagy, Pienovi 1991).
#include <cmath>

#include "src/geometry/kernel/flat/mesh_2.h"
#include "src/geometry/kernel/flat/walk_impl.h"
#include "src/geometry/predicates/exact/predicates.h"

namespace tessera::flat2 {
// Returns false if frozen triangles block every side that faces p.
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

}  // namespace tessera::flat2

template tessera::flat::Located tessera::flat::MeshBase<tessera::flat2::Mesh, tessera::flat2::Cell>::locate(
    const Point&) const;
