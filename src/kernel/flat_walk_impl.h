// Point location where holes of frozen cells can be in the way. For flat_walk_2.cc and flat_walk_3.cc.
#pragma once

#include <algorithm>
#include <functional>
#include <limits>
#include <queue>
#include <unordered_set>
#include <utility>
#include <vector>

#include "src/base/check.h"
#include "src/kernel/flat_mesh.h"

namespace tessera::flat {

template <class Mesh, class Cell>
Located MeshBase<Mesh, Cell>::locate(const Point& p) const {
  Located found;
  if (self().walk(p, last_, found)) return found;
  const Word start = near_by_chance(p);
  if (self().walk(p, start, found)) return found;
  return search(p, start);
}

// Of a few cells the one nearest to p: beyond a hole, most of the time.
template <class Mesh, class Cell>
Word MeshBase<Mesh, Cell>::near_by_chance(const Point& p) const {
  Word best = last_;
  double least = std::numeric_limits<double>::infinity();
  std::uint64_t random = last_;
  for (int k = 0; k < 64; ++k) {
    random = random * 6364136223846793005u + 1442695040888963407u;
    const Word slot = static_cast<Word>((random >> 33) % cells.size());
    if (cells[slot].dead()) continue;
    const double distance = squared_distance<dimension>(p, points[cells[slot].v[0]]);
    if (distance < least) least = distance, best = slot;
  }
  return best;
}

// Nearest cells first, from one to its neighbours. Those that are left are connected through the infinite ones.
template <class Mesh, class Cell>
Located MeshBase<Mesh, Cell>::search(const Point& p, Word start) const {
  using Entry = std::pair<double, Word>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  std::unordered_set<Word> seen;
  const auto meet = [&](Word slot) {
    if (!seen.insert(slot).second) return;
    double distance = std::numeric_limits<double>::infinity();
    for (const Vertex v : cells[slot].v) {
      if (v != infinite_vertex) distance = std::min(distance, squared_distance<dimension>(p, points[v]));
    }
    queue.emplace(distance, slot);
  };
  meet(start);
  while (!queue.empty()) {
    const Word slot = queue.top().second;
    queue.pop();
    for (const Vertex v : cells[slot].v) {
      if (v != infinite_vertex && same_place<dimension>(points[v], p)) return {slot, v};
    }
    if (self().conflicts(p, slot)) return {slot, 0};
    for (const Word across : cells[slot].n) {
      if (!(across & frozen_bit)) meet(across >> 2);
    }
  }
  check(false, "every point is in conflict with a cell that is not frozen");
  return {};
}

}  // namespace tessera::flat
