// Removal of a vertex. The points around the vertex are triangulated by themselves. The cells of this triangulation
// that are in conflict with the vertex fill the hole. The code is simple rather than fast, because only a policy for
// tests removes vertices. mesh_2.cc and mesh_3.cc include this file.
#pragma once

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <vector>

#include "src/base/check.h"
#include "src/geometry/kernel/flat/mesh.h"

namespace tessera::flat {

// The vertices of the facet opposite corner i, sorted.
template <class Cell>
auto sorted_facet(const Cell& cell, Index i) {
  std::array<Vertex, Cell::dimension> facet;
  for (std::size_t k = 0; k < facet.size(); ++k) facet[k] = cell.vertex(Cell::facet_of[i][k]);
  std::sort(facet.begin(), facet.end());
  return facet;
}

template <class Mesh, class Cell>
bool MeshBase<Mesh, Cell>::remove(Vertex v) {
  std::vector<Index> star;
  self().around(v, star);
  std::vector<Vertex> near;
  std::map<std::array<Vertex, dimension>, Index> link;  // the facets opposite v, with the neighbours across
  for (const Index slot : star) {
    const Cell& c = cells[slot];
    near.insert(near.end(), c.v, c.v + corners);
    const Index i = static_cast<Index>(std::find(c.v, c.v + corners, v) - c.v);
    check(!(c.n[i] & frozen_bit), "a removed vertex is not joined to a frozen cell");
    link[sorted_facet(c, i)] = c.n[i];
  }
  std::unique_ptr<Mesh> small;  // a mesh of the points around v; its vertex i is near[i - 1]
  const auto gather = [&] {
    std::sort(near.begin(), near.end());
    near.erase(std::unique(near.begin(), near.end()), near.end());
    std::erase_if(near, [&](Vertex w) { return w == v || w == infinite_vertex; });
    small = std::make_unique<Mesh>();
    for (const Vertex w : near) small->add(points[w]);
    for (Vertex i = 1; i <= near.size() && small->spanned() < dimension; ++i) small->extend_simplex(i);
    return small->spanned() == dimension;
  };
  if (!gather()) {
    // All points around v are coplanar, or collinear. The star of v stays the same with the points across the link
    // added.
    for (const auto& [facet, across] : link) near.push_back(cells[across >> 2].v[across & 3]);
    if (!gather()) return false;
  }
  small->start();
  for (Vertex i = 1; i <= near.size(); ++i) {
    if (!small->in_simplex(i)) small->insert(i);
  }
  const Point p = points[v];
  small->find_zone(p, small->locate(p).cell);

  newest_ = none;
  for (const Index slot : star) {
    cells[slot].free();
    free_.push_back(slot);
  }
  std::map<Index, Index> slot_of;
  for (std::size_t i = 0; i < small->zone_size(); ++i) slot_of[small->zone_cell(i)] = new_slot();
  for (const auto& [z, slot] : slot_of) {
    const Cell& from = small->cells[z];
    Cell& to = cells[slot];
    Corners names;
    for (Index i = 0; i < corners; ++i) {
      const Vertex w = from.vertex(i);
      names[i] = w == infinite_vertex ? w : near[w - 1];
    }
    to.set(names.data());
    for (Index i = 0; i < corners; ++i) {
      const auto inside = slot_of.find(from.n[i] >> 2);
      if (inside != slot_of.end()) {
        to.n[i] = 4 * inside->second + (from.n[i] & 3);
        continue;
      }
      const Index across = link.at(sorted_facet(to, i));
      to.n[i] = across;
      cells[across >> 2].n[across & 3] = 4 * slot + i;
    }
    last_ = slot;
  }
  return true;
}

}  // namespace tessera::flat
