// Point location: a visibility walk from where the last insertion was. It ends, because the triangulation is Delaunay
// (De Floriani, Falcidieno, Nagy, Pienovi 1991).
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <unordered_set>
#include <utility>
#include <vector>

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
  Word from = 0;
  if (const Triangle& t = all[slot]; exact::orient2(point(t.v[1]), point(t.v[2]), p) < 0) {
    if (t.n[0] & frozen_bit) return false;
    slot = t.n[0] >> 2;
    from = t.n[0] & 3;
  }
  // p is on the inner side of edge `from`, which goes from r to l; both are relative to p.
  struct Vector {
    double x, y;
  };
  const auto relative = [&](Vertex v) { return Vector{point(v).x - p.x, point(v).y - p.y}; };
  Vector r = relative(all[slot].v[next_of[from]]), l = relative(all[slot].v[before[from]]);
  while (true) {
    const Triangle& t = all[slot];
    if (t.v[from] == infinite_vertex) {  // strictly outside the hull
      found = {slot, 0};
      return true;
    }
    const Vector c = relative(t.v[from]);
    // Both other edges are asked at once, and the way on is chosen without a jump: nobody can foresee which one it is.
    // The error is that of exact::filter::orient2.
    const double l1 = l.x * c.y, l2 = l.y * c.x, r1 = c.x * r.y, r2 = c.y * r.x;
    const double l_side = l1 - l2, r_side = r1 - r2;  // of the edge from l to c, and of that from c to r
    constexpr double u = exact::filter::u, underflow = exact::filter::underflow;
    const bool l_certain = std::abs(l_side) > 5 * u * (std::abs(l1) + std::abs(l2)) + underflow;
    const bool r_certain = std::abs(r_side) > 5 * u * (std::abs(r1) + std::abs(r2)) + underflow;
    bool across_l = l_side < 0, across_r = r_side < 0;
    if (!(l_certain & r_certain)) [[unlikely]] {
      across_l = exact::orient2(point(t.v[before[from]]), point(t.v[from]), p) < 0;
      across_r = exact::orient2(point(t.v[from]), point(t.v[next_of[from]]), p) < 0;
    }
    if (!(across_l | across_r)) {
      found = {slot, 0};
      for (const Vertex v : t.v) {
        if (equal(point(v), p)) found.same = v;
      }
      return true;
    }
    const Word next_l = t.n[next_of[from]], next_r = t.n[before[from]];
    if (((across_l ? next_l : 0) | (across_r ? next_r : 0)) & frozen_bit) [[unlikely]] {
      across_l &= !(next_l & frozen_bit);
      across_r &= !(next_r & frozen_bit);
      if (!(across_l | across_r)) return false;
    }
    // Seen from the next triangle, c is behind the edge to l and before that to r.
    const Word across = across_l ? next_l : next_r;
    l = across_l ? l : c;
    r = across_l ? c : r;
    slot = across >> 2;
    from = across & 3;
  }
}

Located Mesh::locate(const Point& p) {
  Located found;
  if (walk(p, last_, found)) return found;
  const Word start = near_by_chance(p);
  if (walk(p, start, found)) return found;
  return search(p, start);
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

// Nearest triangles first, from one to its neighbours. Those that are left are connected through the infinite ones.
Located Mesh::search(const Point& p, Word start) const {
  using Entry = std::pair<double, Word>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  std::unordered_set<Word> seen;
  const auto meet = [&](Word slot) {
    if (!seen.insert(slot).second) return;
    double distance = std::numeric_limits<double>::infinity();
    for (const Vertex v : triangles[slot].v) {
      if (v != infinite_vertex) distance = std::min(distance, distance_to(p, point(v)));
    }
    queue.emplace(distance, slot);
  };
  meet(start);
  while (!queue.empty()) {
    const Word slot = queue.top().second;
    queue.pop();
    const Triangle& t = triangles[slot];
    for (const Vertex v : t.v) {
      if (v != infinite_vertex && equal(point(v), p)) return {slot, v};
    }
    if (conflicts(p, t)) return {slot, 0};
    for (const Word across : t.n) {
      if (!(across & frozen_bit)) meet(across >> 2);
    }
  }
  check(false, "every point is in conflict with a triangle that is not frozen");
  return {};
}

}  // namespace tessera::flat2
