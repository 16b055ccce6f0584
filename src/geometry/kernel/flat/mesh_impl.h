// Functions of MeshBase. mesh_2.cc and mesh_3.cc include this file and instantiate them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "src/base/check.h"
#include "src/geometry/kernel/flat/mesh.h"

namespace tessera::flat {

template <class Mesh, class Cell>
void MeshBase<Mesh, Cell>::drop_cells() {
  cells.clear();
  free_.clear();
  nearby_.clear();
  self().release_scratch();
  spanned_ = -1;
  frozen_ = last_ = 0;
  newest_ = none;
}

template <class Mesh, class Cell>
void MeshBase<Mesh, Cell>::extend_simplex(Vertex v) {
  if (self().spans_more(points[v])) simplex_[static_cast<std::size_t>(++spanned_)] = v;
}

template <class Mesh, class Cell>
bool MeshBase<Mesh, Cell>::in_simplex(Vertex v) const {
  return std::find(simplex_.begin(), simplex_.end(), v) != simplex_.end();
}

template <class Mesh, class Cell>
void MeshBase<Mesh, Cell>::start() {
  check(spanned_ == dimension && cells.size() == 0, "a triangulation starts with a simplex");
  if (!self().positive(simplex_)) std::swap(simplex_[0], simplex_[1]);
  // Foreign points come later, near the boundary of these points. Reserving space for their cells avoids moving all
  // cells.
  const double n = static_cast<double>(points.size());
  const double outside = 8 * (dimension == 3 ? std::cbrt(n) * std::cbrt(n) : std::sqrt(n));
  cells.reserve(Mesh::cells_a_vertex * (std::size_t{points.size()} + static_cast<std::size_t>(outside)) + 64);
  cells.resize(corners + 1);
  cells[0].set(simplex_.data());
  // A facet and the inner corner in front of it make a positive cell. So do the facet and the infinite vertex behind
  // it.
  for (Index i = 0; i < corners; ++i) {
    Corners outer{};
    for (std::size_t k = 0; k + 1 < corners; ++k) outer[k] = simplex_[Cell::facet_of[i][k]];
    if (dimension % 2 == 0) std::swap(outer[0], outer[1]);
    cells[1 + i].set(outer.data());
  }
  for (Index c = 0; c <= corners; ++c) {
    for (Index i = 0; i < corners; ++i) {
      for (Index d = 0; d <= corners; ++d) {
        const Index facet = d == c ? corners : common_facet(cells[c], i, cells[d]);
        if (facet < corners) cells[c].n[i] = 4 * d + facet;
      }
    }
  }
}

template <class Mesh, class Cell>
void MeshBase<Mesh, Cell>::before_zone() {
  if (usual_left_ == 0 || --usual_left_ > 0) [[likely]]
    return;
  self().release_scratch();
}

template <class Mesh, class Cell>
void MeshBase<Mesh, Cell>::insert(Vertex v) {
  const Point p = points[v];
  const Located found = locate(p);
  check_read(found.same == 0, "two points of a kernel are equal");
  self().find_zone(p, found.cell);
  self().fill(v);
}

template <class Mesh, class Cell>
Index MeshBase<Mesh, Cell>::new_slot() {
  if (!free_.empty()) {
    const Index slot = free_.back();
    free_.pop_back();
    return slot;
  }
  if (cells.size() >= cells_max_) throw KernelFull();
  cells.resize(cells.size() + 1);
  return static_cast<Index>(cells.size() - 1);
}

// Most calls ask for a vertex near the vertex asked before, or near the newest vertex. So last_ is tried first.
template <class Mesh, class Cell>
Index MeshBase<Mesh, Cell>::incident(Vertex v) const {
  const auto has_v = [&](Index slot) {
    const Cell& c = cells[slot];
    return !c.dead() && std::find(c.v, c.v + corners, v) != c.v + corners;
  };
  if (has_v(last_)) return last_;
  if (v != infinite_vertex) return last_ = locate(points[v]).cell;
  Index slot = 0;
  while (!has_v(slot)) ++slot;
  return slot;
}

// Has room for some more points, as a copy is made to be changed.
template <class Mesh, class Cell>
void MeshBase<Mesh, Cell>::copy(const Mesh& other) {
  check(other.frozen_ == 0, "a kernel with frozen cells is not copied");
  drop_cells();
  points.copy(other.points);
  const std::size_t n = other.cells.size();
  cells.reserve(n + n / 8 + 64);
  cells.resize(n);
  std::copy(other.cells.data(), other.cells.data() + n, cells.data());
  free_ = other.free_;
  simplex_ = other.simplex_;
  spanned_ = other.spanned_;
  last_ = other.last_;
}

template <class Mesh, class Cell>
Array<Cell> MeshBase<Mesh, Cell>::take_cells() {
  return std::move(cells);
}

template <class Mesh, class Cell>
void MeshBase<Mesh, Cell>::adopt(Array<Cell> others, Index frozen) {
  cells = std::move(others);
  frozen_ = frozen;
  free_.clear();
  nearby_.clear();
  last_ = 0;
  newest_ = none;
  for (Index slot = 0; slot < cells.size(); ++slot) {
    if (cells[slot].dead()) {
      free_.push_back(slot);
    } else {
      last_ = slot;
    }
  }
}

template <class Mesh, class Cell>
void MeshBase<Mesh, Cell>::compact() {
  newest_ = none;
  nearby_.clear();
  self().release_scratch();
  std::sort(free_.begin(), free_.end());
  for (std::size_t next = 0, end = free_.size(); next < end;) {
    const Index last = static_cast<Index>(cells.size() - 1);
    if (free_[end - 1] == last) {
      --end;
    } else {
      const Index slot = free_[next++];
      cells[slot] = cells[last];
      for (Index i = 0; i < corners; ++i) {
        const Index across = cells[slot].n[i];
        if (!(across & frozen_bit)) cells[across >> 2].n[across & 3] = 4 * slot + i;
      }
      if (last_ == last) last_ = slot;
    }
    cells.resize(last);
  }
  release(free_);
  if (cells.touched() - cells.bytes() > cells.bytes() / 8) cells.trim();
}

template <class Mesh, class Cell>
std::size_t MeshBase<Mesh, Cell>::base_memory() const {
  return points.memory() + cells.touched() + free_.capacity() * sizeof(Index) + nearby_.memory();
}

}  // namespace tessera::flat
