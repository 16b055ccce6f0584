// Removal of a vertex: the hole is filled by the cells, in conflict with the vertex, of the Delaunay triangulation of
// the points around it. Simple rather than fast: only a policy for tests removes vertices.
#include <algorithm>
#include <map>
#include <memory>

#include "src/base/check.h"
#include "src/kernel/exact_predicates.h"
#include "src/kernel/flat_mesh_3.h"
#include "src/kernel/kernel.h"

namespace tessera::flat {
namespace {

// The vertices of a list of cells but for v and the infinite one, sorted.
std::vector<Vertex> others(std::vector<Vertex> corners, Vertex v) {
  std::sort(corners.begin(), corners.end());
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  std::erase_if(corners, [&](Vertex w) { return w == v || w == infinite_vertex; });
  return corners;
}

// Positions in `around` of four points that are not coplanar; false if there are none.
bool find_simplex(const Points& points, const std::vector<Vertex>& around, std::array<Vertex, 4>& found) {
  const auto at = [&](Vertex i) -> const Point& { return points[around[i]]; };
  const Vertex n = static_cast<Vertex>(around.size());
  if (n < 4) return false;
  Vertex c = 2;
  while (c < n && collinear_3(at(0), at(1), at(c))) ++c;
  for (Vertex d = c + 1; d < n; ++d) {
    if (exact::orient3(at(0), at(1), at(c), at(d)) == 0) continue;
    found = {0, 1, c, d};
    return true;
  }
  return false;
}

using Triangle = std::array<Vertex, 3>;
Triangle facet(const Cell& cell, Word opposite) {
  Triangle t;
  for (std::size_t k = 0; k < 3; ++k) t[k] = cell.v[facet_of[opposite][k]] & vertex_mask;
  std::sort(t.begin(), t.end());
  return t;
}

}  // namespace

bool Mesh::remove(Vertex v) {
  std::vector<Word> star;
  around(v, star);
  std::vector<Vertex> corners;
  std::map<Triangle, Word> link;  // facets opposite v: what lies across
  for (const Word slot : star) {
    const Cell& c = cells[slot];
    corners.insert(corners.end(), c.v, c.v + 4);
    const Word i = static_cast<Word>(std::find(c.v, c.v + 4, v) - c.v);
    check(!(c.n[i] & frozen_bit), "a removed vertex is not joined to a frozen cell");
    link[facet(c, i)] = c.n[i];
  }
  std::vector<Vertex> near = others(corners, v);
  std::array<Vertex, 4> first;
  if (!find_simplex(points, near, first)) {
    // All around v are coplanar. The star of v is the same with more points: those across the link.
    for (const auto& [triangle, across] : link) corners.push_back(cells[across >> 2].v[across & 3]);
    near = others(corners, v);
    if (!find_simplex(points, near, first)) return false;
  }
  const auto small = std::make_unique<Mesh>();
  for (const Vertex w : near) small->points.add(points[w]);
  for (Vertex& i : first) ++i;
  small->start(first);
  for (Vertex i = 1; i <= near.size(); ++i) {
    if (std::find(first.begin(), first.end(), i) == first.end()) small->insert(i);
  }
  const Point p = points[v];
  small->find_zone(p, small->locate(p).cell);

  for (const Word slot : star) {
    cells[slot].v[0] = dead_vertex;
    free_.push_back(slot);
  }
  const auto name = [&](Word i) {
    return (i & vertex_mask) == infinite_vertex ? infinite_vertex : near[(i & vertex_mask) - 1];
  };
  std::map<Word, Word> slot_of;
  for (std::size_t i = 0; i < small->zone_size(); ++i) slot_of[small->zone_cell(i)] = new_slot();
  for (const auto& [z, slot] : slot_of) {
    const Cell& from = small->cells[z];
    Cell& to = cells[slot];
    for (Word i = 0; i < 4; ++i) to.v[i] = name(from.v[i]);
    for (Word i = 0; i < 4; ++i) {
      const auto inside = slot_of.find(from.n[i] >> 2);
      if (inside != slot_of.end()) {
        to.n[i] = 4 * inside->second + (from.n[i] & 3);
        continue;
      }
      const Word across = link.at(facet(to, i));
      to.n[i] = across;
      cells[across >> 2].n[across & 3] = 4 * slot + i;
    }
    last_ = slot;
  }
  return true;
}

}  // namespace tessera::flat
