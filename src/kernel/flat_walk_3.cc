// Point location: a visibility walk from where the last insertion was. It ends, because the triangulation is Delaunay
// (De Floriani, Falcidieno, Nagy, Pienovi 1991; Edelsbrunner 1990: in front of a point its cells are ordered).
#include <algorithm>
#include <limits>
#include <queue>
#include <unordered_set>

#include "src/base/check.h"
#include "src/kernel/flat_mesh_3.h"
#include "src/kernel/flat_predicates_3.h"

namespace tessera::flat {
namespace {

double distance_to(const Point& p, const Point& q) {
  const double x = p.x - q.x, y = p.y - q.y, z = p.z - q.z;
  return x * x + y * y + z * z;
}

}  // namespace

// False if the way was blocked by frozen cells on every side that faces p.
bool Mesh::walk(const Point& p, Word slot, Located& found) const {
  if (cells[slot].infinite()) {
    const Word inside = cells[slot].n[3];
    if (inside & frozen_bit) return false;
    slot = inside >> 2;
  }
  Step step = walk_surely(p, {slot, 8, false});
  if (step.arrived) {
    found = {step.slot, 0};
    return true;
  }
  while (true) {
    const Cell& c = cells[step.slot];
    Word across = frozen_bit;
    bool blocked = false, touching = false;
    for (Word j = 0; j < 4; ++j) {
      const Word i = (turn_ + j) & 3;
      if (i == step.from) continue;
      const auto& f = facet_of[i];
      const int side = orientation(p, points[c.v[f[0]]], points[c.v[f[1]]], points[c.v[f[2]]]);
      touching |= side == 0;
      if (side >= 0) continue;
      across = c.n[i];
      if (!(across & frozen_bit)) break;
      blocked = true;
    }
    if (across & frozen_bit) {  // no way on
      if (blocked) return false;
      found = {step.slot, 0};
      if (touching) {
        for (const Word v : c.v) {
          if (points[v] == p) found.same = v;
        }
      }
      return true;
    }
    ++turn_;
    step = {across >> 2, across & 3, false};
    if (cells[step.slot].infinite()) {  // strictly outside the hull
      found = {step.slot, 0};
      return true;
    }
  }
}

Located Mesh::locate(const Point& p) const {
  ++turn_;
  Located found;
  if (walk(p, last_, found)) return found;
  const Word start = near_by_chance(p);
  if (walk(p, start, found)) return found;
  return search(p, start);
}

// Of a few cells the one nearest to p: beyond a hole, most of the time.
Word Mesh::near_by_chance(const Point& p) const {
  Word best = last_;
  double least = std::numeric_limits<double>::infinity();
  std::uint64_t random = turn_;
  for (int k = 0; k < 64; ++k) {
    random = random * 6364136223846793005u + 1442695040888963407u;
    const Word slot = static_cast<Word>((random >> 33) % cells.size());
    if (cells[slot].dead()) continue;
    const double distance = distance_to(p, points[cells[slot].v[0]]);
    if (distance < least) least = distance, best = slot;
  }
  ++turn_;
  return best;
}

// Nearest cells first, from one to its neighbours. Live cells are connected through the infinite ones.
Located Mesh::search(const Point& p, Word start) const {
  using Entry = std::pair<double, Word>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  std::unordered_set<Word> seen;
  const auto meet = [&](Word slot) {
    if (!seen.insert(slot).second) return;
    double distance = std::numeric_limits<double>::infinity();
    for (const Word v : cells[slot].v) {
      if (v != infinite_vertex) distance = std::min(distance, distance_to(p, points[v]));
    }
    queue.emplace(distance, slot);
  };
  meet(start);
  while (!queue.empty()) {
    const Word slot = queue.top().second;
    queue.pop();
    for (const Word v : cells[slot].v) {
      if (v != infinite_vertex && points[v] == p) return {slot, v};
    }
    if (conflicts(p, slot)) return {slot, 0};
    for (const Word across : cells[slot].n) {
      if (!(across & frozen_bit)) meet(across >> 2);
    }
  }
  check(false, "every point is in conflict with a cell that is not frozen");
  return {};
}

}  // namespace tessera::flat
