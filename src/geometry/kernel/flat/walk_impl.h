// Point location where holes of frozen cells may be in the way. mesh_2.cc and mesh_3.cc include this file.
#pragma once

#include <algorithm>
#include <functional>
#include <limits>
#include <queue>
#include <unordered_set>
#include <utility>
#include <vector>

#include "src/base/check.h"
#include "src/geometry/kernel/flat/mesh.h"

namespace tessera::flat {

template <class Mesh, class Cell>
Located MeshBase<Mesh, Cell>::locate(const Point& p) const {
  Located found;
  if (self().walk(p, last_, found)) return found;
  std::vector<Index> starts = nearby(p);
  if (starts.empty()) starts.push_back(last_);
  if (self().walk(p, starts.front(), found)) return found;
  return search(p, starts);
}

// Returns cells near p, the nearest first. A hole leaves thin layers of cells, and a search that begins far away would
// visit most of them. The nearest cell may lie on the other side of the hole, but hardly all eight of them do.
template <class Mesh, class Cell>
std::vector<Index> MeshBase<Mesh, Cell>::nearby(const Point& p) const {
  constexpr std::size_t step = 16;  // every 16th cell: 2 bytes a cell
  if (nearby_.empty() || live_cells() > 2 * nearby_of_) {
    std::vector<typename NearbyCells<dimension>::CellSample> samples;
    samples.reserve(cells.size() / step + 1);
    for (std::size_t slot = 0; slot < cells.size(); slot += step) {
      if (!cells[slot].dead()) samples.push_back({points[cells[slot].v[0]], static_cast<Index>(slot)});
    }
    nearby_.set(std::move(samples));
    nearby_of_ = live_cells();
  }
  return nearby_.nearest(p, [&](Index slot) { return slot < cells.size() && !cells[slot].dead(); });
}

// A best-first search by distance to p, from a cell to its neighbours. The live cells are connected through the
// infinite cells.
template <class Mesh, class Cell>
Located MeshBase<Mesh, Cell>::search(const Point& p, const std::vector<Index>& starts) const {
  using Entry = std::pair<double, Index>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  std::unordered_set<Index> seen;
  const auto meet = [&](Index slot) {
    if (!seen.insert(slot).second) return;
    double distance = std::numeric_limits<double>::infinity();
    for (const Vertex v : cells[slot].v) {
      if (v != infinite_vertex) distance = std::min(distance, squared_distance<dimension>(p, points[v]));
    }
    queue.emplace(distance, slot);
  };
  for (const Index start : starts) meet(start);
  while (!queue.empty()) {
    const Index slot = queue.top().second;
    queue.pop();
    for (const Vertex v : cells[slot].v) {
      if (v != infinite_vertex && same_place<dimension>(points[v], p)) return {slot, v};
    }
    if (self().conflicts(p, slot)) return {slot, 0};
    for (const Index across : cells[slot].n) {
      if (!(across & frozen_bit)) meet(across >> 2);
    }
  }
  throw Unsound("a point is in conflict with no cell that is left");
}

}  // namespace tessera::flat
