// Point location: a visibility walk from where the last insertion was. It ends, because the triangulation is Delaunay
// (De Floriani, Falcidieno, Nagy, Pienovi 1991).
#include <limits>

#include "src/base/check.h"
#include "src/kernel/exact_predicates.h"
#include "src/kernel/flat_mesh_2.h"

namespace tessera::flat2 {
namespace {

bool equal(const Point& p, const Point& q) { return p.x == q.x && p.y == q.y; }

double distance_to(const Point& p, const Point& q) {
  const double x = p.x - q.x, y = p.y - q.y;
  return x * x + y * y;
}

}  // namespace

// False if the way was blocked by frozen triangles on every side that faces p.
bool Mesh::walk(const Point& p, Word slot, Located& found) const {
  const Triangle* const all = triangles.data();
  if (all[slot].infinite()) {
    const Word inside = all[slot].n[all[slot].v[1] == infinite_vertex ? 1 : 2];
    if (inside & frozen_bit) return false;
    slot = inside >> 2;
  }
  // p is on the inner side of edge `from`, which does not need to be asked; in the first triangle nothing is known.
  const auto side = [&](const Triangle& t, Word i) {
    return exact::orient2(point(t.v[next_of[i]]), point(t.v[before[i]]), p);
  };
  Word from = 0;
  if (const Triangle& t = all[slot]; side(t, 0) < 0) {
    if (t.n[0] & frozen_bit) return false;
    slot = t.n[0] >> 2;
    from = t.n[0] & 3;
  }
  while (true) {
    const Triangle& t = all[slot];
    if (t.infinite()) {  // strictly outside the hull
      found = {slot, 0};
      return true;
    }
    bool blocked = false;
    Word across = frozen_bit;
    for (const Word i : {next_of[from], before[from]}) {
      if (side(t, i) >= 0) continue;
      across = t.n[i];
      if (!(across & frozen_bit)) break;
      blocked = true;
    }
    if (across & frozen_bit) {
      if (blocked) return false;
      found = {slot, 0};
      for (const Vertex v : t.v) {
        if (equal(point(v), p)) found.same = v;
      }
      return true;
    }
    slot = across >> 2;
    from = across & 3;
  }
}

Located Mesh::locate(const Point& p) {
  Located found;
  if (walk(p, last_, found)) return found;
  if (walk(p, near_by_chance(p), found)) return found;
  return search(p);
}

// Of a few triangles the one nearest to p: beyond a hole, most of the time.
Word Mesh::near_by_chance(const Point& p) const {
  Word best = last_;
  double least = std::numeric_limits<double>::infinity();
  std::uint64_t random = last_;
  for (int k = 0; k < 64; ++k) {
    random = random * 6364136223846793005u + 1442695040888963407u;
    const Word slot = static_cast<Word>((random >> 33) % triangles.size());
    if (triangles[slot].dead()) continue;
    const double distance = distance_to(p, point(triangles[slot].v[0]));
    if (distance < least) least = distance, best = slot;
  }
  return best;
}

// All triangles, one after the other: only for points between two holes.
Located Mesh::search(const Point& p) const {
  for (Word slot = 0; slot < triangles.size(); ++slot) {
    const Triangle& t = triangles[slot];
    if (t.dead()) continue;
    for (const Vertex v : t.v) {
      if (v != infinite_vertex && equal(point(v), p)) return {slot, v};
    }
    if (conflicts(p, t)) return {slot, 0};
  }
  check(false, "every point is in conflict with a triangle that is not frozen");
  return {};
}

}  // namespace tessera::flat2
