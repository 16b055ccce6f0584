// Point location in 3D: a visibility walk that starts at the last insertion. The walk ends, because the triangulation
// is Delaunay (De Floriani, Falcidieno, Nagy, Pienovi 1991; Edelsbrunner 1990: seen from a point, Delaunay cells have
// an order from front to back).
#include "src/geometry/kernel/flat/mesh_3.h"
#include "src/geometry/kernel/flat/predicates_3.h"
#include "src/geometry/kernel/flat/walk_impl.h"

namespace tessera::flat3 {

// Returns false if frozen cells block every side that faces p.
bool Mesh::walk(const Point& p, Index slot, Located& found) const {
  ++turn_;
  if (cells[slot].infinite()) {
    const Index inside = cells[slot].n[3];
    if (inside & frozen_bit) return false;
    slot = inside >> 2;
  }
  WalkStep step = walk_surely(p, {slot, 8, false});
  if (step.arrived) {
    found = {step.slot, 0};
    return true;
  }
  while (true) {
    const Cell& c = cells[step.slot];
    // Vertices are compared first. Where p is a vertex three of the orientations are zero, and zeros take long to
    // prove.
    for (const Index v : c.v) {
      if (points[v] != p) continue;
      found = {step.slot, v};
      return true;
    }
    Index across = frozen_bit;
    bool blocked = false;
    for (Index j = 0; j < 4; ++j) {
      const Index i = (turn_ + j) & 3;
      if (i == step.from) continue;
      const auto& f = Cell::facet_of[i];
      if (orientation_3(p, points[c.v[f[0]]], points[c.v[f[1]]], points[c.v[f[2]]]) >= 0) continue;
      across = c.n[i];
      if (!(across & frozen_bit)) break;
      blocked = true;
    }
    if (across & frozen_bit) {  // the walk cannot go on
      if (blocked) return false;
      found = {step.slot, 0};
      return true;
    }
    ++turn_;
    step = {across >> 2, across & 3, false};
    if (cells[step.slot].infinite()) {  // p is strictly outside the hull
      found = {step.slot, 0};
      return true;
    }
  }
}

}  // namespace tessera::flat3

template tessera::flat::Located tessera::flat::MeshBase<tessera::flat3::Mesh, tessera::flat3::Cell>::locate(
    const Point&) const;
