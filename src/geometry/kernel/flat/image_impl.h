// Saving and loading. An image may come from another kernel, so the infinite vertex may be anywhere in a cell.
#pragma once

#include <algorithm>
#include <utility>

#include "src/geometry/kernel/flat/flat_kernel_impl.h"

namespace tessera::flat {

template <class Mesh>
bool in_range(const KernelImage& image, const Mesh& mesh) {
  constexpr int d = Mesh::dimension;
  constexpr Index corners = Mesh::corners;
  const std::size_t n = image.points.size(), m = image.cells.vertices.size() / corners;
  if (n > mesh.points.most() || image.local.size() != n || image.alive.size() != n) return false;
  if (image.cells.vertices.size() != corners * m || image.cells.neighbors.size() != corners * m) return false;
  if (m > mesh.most_cells() || image.dimension < -1 || image.dimension > d || (image.dimension < d) != (m == 0))
    return false;
  const auto vertex_there = [&](Vertex v) { return v == infinite_vertex || (v <= n && image.alive[v - 1]); };
  if (!std::all_of(image.cells.vertices.begin(), image.cells.vertices.end(), vertex_there)) return false;
  return std::all_of(image.cells.neighbors.begin(), image.cells.neighbors.end(), [&](std::uint32_t c) {
    return c & across_frozen ? (c & ~across_frozen) / corners < image.frozen : c < m;
  });
}

// Fills `cells` with the cells of the list, with the infinite vertex last and neighbours that name facets. Returns
// false if the cells cannot be a triangulation.
template <class Cell>
bool read_cells(const CellList& list, Array<Cell>& cells) {
  constexpr Index corners = Cell::corners;
  const std::size_t m = list.vertices.size() / corners;
  cells.resize(m);
  for (std::size_t c = 0; c < m; ++c) {
    cells[c].set(&list.vertices[corners * c]);
    for (Index i = 0; i < corners; ++i) cells[c].n[i] = list.neighbors[corners * c + i];
    if (!put_infinite_last(cells[c])) return false;
  }
  std::size_t named = 0, named_back = 0;
  for (Index c = 0; c < m; ++c) {
    for (Index i = 0; i < corners; ++i) {
      Index& across = cells[c].n[i];
      if (across & frozen_bit) continue;
      const Cell& to = cells[across];
      const bool back = across < c;  // then `to` names facets already, and must name this one
      const Index facet =
          back ? static_cast<Index>(std::find(to.n, to.n + corners, 4 * c + i) - to.n) : common_facet(cells[c], i, to);
      if (facet == corners) return false;
      ++(back ? named_back : named);
      across = 4 * across + facet;
    }
  }
  return named == named_back;
}

template <class Mesh>
KernelImage FlatKernel<Mesh>::save() const {
  KernelImage image;
  const Vertex n = vertices();
  image.dimension = dimension();
  image.frozen = mesh_.frozen();
  image.points.resize(n);
  image.local.resize(n);
  image.alive.resize(n);
  for (Vertex v = 1; v <= n; ++v) {
    image.local[v - 1] = is_local(v);
    if (!alive(v)) continue;
    image.points[v - 1] = point(v);
    image.alive[v - 1] = 1;
  }
  if (full()) image.cells = cells();
  return image;
}

template <class Mesh>
bool FlatKernel<Mesh>::load(const KernelImage& image) {
  Array<Cell> loaded;
  if (!in_range(image, mesh_) || !read_cells(image.cells, loaded)) return false;
  reset();
  mesh_.points.copy(image.points);
  for (std::size_t i = 0; i < image.points.size(); ++i) {
    labels_.push_back(
        static_cast<std::uint8_t>((image.alive[i] ? alive_bit : 0) | (image.local[i] ? is_local_bit : 0)));
  }
  span();
  if (dimension() != image.dimension) {
    reset();
    return false;
  }
  mesh_.adopt(std::move(loaded), image.frozen);
  return true;
}

}  // namespace tessera::flat
