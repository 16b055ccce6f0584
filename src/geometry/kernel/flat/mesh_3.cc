#include "src/geometry/kernel/flat/mesh_3.h"

#include <algorithm>
#include <cstring>

#include "src/base/check.h"
#include "src/geometry/kernel/flat/mesh_impl.h"
#include "src/geometry/kernel/flat/predicates_3.h"
#include "src/geometry/kernel/flat/remove_impl.h"
#include "src/geometry/kernel/flat/walk_impl.h"

namespace tessera::flat3 {

// A call that ended with KernelFull may have left numbers that are not 0.
void Mesh::drop_cells() {
  MeshBase::drop_cells();
  number_.clear();
}

bool Mesh::spans_more(const Point& p) const {
  if (spanned_ < 1) return spanned_ < 0 || corner(0) != p;
  if (spanned_ == 1) return !exact::collinear_3(corner(0), corner(1), p);
  return exact::orientation_3(corner(0), corner(1), corner(2), p) != 0;
}

bool Mesh::positive(const Corners& v) const {
  return orientation_3(points[v[0]], points[v[1]], points[v[2]], points[v[3]]) > 0;
}

bool Mesh::conflicts(const Point& p, Index cell) const {
  const Cell& c = cells[cell];
  const Vertex v0 = c.v[0] & vertex_mask;
  const Point &a = points[v0], &b = points[c.v[1]], &d = points[c.v[2]];
  if (!c.infinite()) return exact::in_sphere_perturbed_3(a, b, d, points[c.v[3]], p) > 0;
  const int side = orientation_3(p, a, b, d);  // positive: p is on the side of the hull
  if (side != 0) return side < 0;
  // In the plane of the facet the facet's circle decides, with the same perturbation. Any sphere through the facet
  // meets the plane in this circle. The fourth point of the sphere never decides a tie: with p in its place the
  // determinant is zero.
  for (const Vertex s : simplex_) {
    const Point& apex = points[s];
    const int up = orientation_3(apex, a, b, d);
    if (up > 0) return exact::in_sphere_perturbed_3(apex, a, b, d, p) > 0;
    if (up < 0) return exact::in_sphere_perturbed_3(apex, b, a, d, p) > 0;
  }
  throw Unsound("the first four vertices do not span the space");
}

// Point location is a visibility walk that starts at the last insertion. The walk ends, because the triangulation is
// Delaunay (De Floriani, Falcidieno, Nagy, Pienovi 1991; Edelsbrunner 1990: seen from a point, Delaunay cells have an
// order from front to back). Returns false if frozen cells block every side that faces p.
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

// New cells take the slots of the zone first, because these are in the cache. Only the remaining slots of the zone are
// freed. The list of free slots is never scanned, because an earlier large zone may have freed very many.
void Mesh::take_slots(Index facets) {
  const Index zone_cells = static_cast<Index>(zone_size_);
  if (slots_.size() < facets) slots_.resize(2 * facets);
  if (zone_.size() < facets) zone_.resize(2 * facets);
  if (facets < zone_cells || !free_.empty()) {
    for (Index f = 0; f < facets; ++f) slots_[f] = f < zone_cells ? zone_[f] >> 2 : new_slot();
    for (Index z = facets; z < zone_cells; ++z) {
      cells[zone_[z] >> 2].free();
      free_.push_back(zone_[z] >> 2);
    }
    return;
  }
  const Index end = static_cast<Index>(cells.size()), added = facets - zone_cells;
  if (end > cells_max_ || added > cells_max_ - end) throw KernelFull();
  cells.resize(end + added);
  const Index* const zone = zone_.data();
  Index* const slots = slots_.data();
  for (Index f = 0; f < facets; ++f) slots[f] = f < zone_cells ? zone[f] >> 2 : end + (f - zone_cells);
}

void Mesh::fill(Vertex v) {
  const Index facets = static_cast<Index>(facets_size_);
  take_slots(facets);
  if (zone_vertices_size_ < small) {
    link_small(facets, v);
  } else {
    link_large(facets, v);
  }
  std::uint8_t* const number = number_.data();
  for (const Vertex w : zone_vertices()) number[w] = 0;
  last_ = slots_[facets - 1];
  newest_ = v;
}

// Writes the new cell over a facet of the boundary, and makes the cell outside name it.
inline void Mesh::put(Cell* all, Index slot, const Facet& facet, Vertex v) {
  Cell& cell = all[slot];
  const Index a = facet.v[0], b = facet.v[1], c = facet.v[2], across = facet.across;
  cell.v[0] = v;
  cell.v[1] = a;
  cell.v[2] = b;
  cell.v[3] = c;
  cell.n[0] = across;
  if (across & frozen_bit) [[unlikely]]
    return;
  Cell& outside = cell_at(all, across);
  outside.v[0] &= vertex_mask;
  outside.n[across & 3] = 4 * slot;
}

// The table gives, for each directed edge of the boundary, the facet of the new cell over that edge. The neighbour
// across is the cell over the reversed edge.
void Mesh::link_small(Index count, Vertex v) {
  Cell* const all = cells.data();
  const Facet* const facets = facets_.data();
  const Index* const slots = slots_.data();
  Index* const table = table_.data();
  for (Index f = 0; f < count; ++f) {
    const Index a = facets[f].number[0], b = facets[f].number[1], c = facets[f].number[2], slot = slots[f];
    put(all, slot, facets[f], v);
    table[b * small + c] = 4 * slot + 1;
    table[c * small + a] = 4 * slot + 2;
    table[a * small + b] = 4 * slot + 3;
  }
  for (Index f = 0; f < count; ++f) {
    const Index a = facets[f].number[0], b = facets[f].number[1], c = facets[f].number[2];
    const Index over_a = table[c * small + b], over_b = table[a * small + c], over_c = table[b * small + a];
    Cell& cell = all[slots[f]];
    cell.n[1] = over_a;
    cell.n[2] = over_b;
    cell.n[3] = over_c;
  }
}

void Mesh::link_large(Index facets, Vertex vertex) {
  for (Index f = 0; f < facets; ++f) put(cells.data(), slots_[f], facets_[f], vertex);
  std::size_t size = 1024;
  // There are 3 edges a facet. For a large zone a small table matters more than a few steps of the search.
  while (size < (zone_size_ > usual_zone ? 4 : 6) * std::size_t{facets}) size *= 2;
  edges_.assign(size, {0, 0});
  const auto find = [&](Index from, Index to) -> Edge& {
    const std::uint64_t key = std::uint64_t{from} << 32 | to;
    std::size_t i = (key * 0x9e3779b97f4a7c15u ^ key >> 29) * 0xbf58476d1ce4e5b9u >> 32;
    for (i &= size - 1; edges_[i].key != 0 && edges_[i].key != key; i = (i + 1) & (size - 1)) {
    }
    edges_[i].key = key;  // never 0, because at most one end is the infinite vertex
    return edges_[i];
  };
  for (Index f = 0; f < facets; ++f) {
    const auto& v = facets_[f].v;
    for (Index k = 0; k < 3; ++k) find(v[(k + 1) % 3], v[(k + 2) % 3]).facet = 4 * slots_[f] + 1 + k;
  }
  for (Index f = 0; f < facets; ++f) {
    const auto& v = facets_[f].v;
    for (Index k = 0; k < 3; ++k) cells[slots_[f]].n[1 + k] = find(v[(k + 2) % 3], v[(k + 1) % 3]).facet;
  }
}

void Mesh::leave() {
  for (std::size_t f = 0; f < facets_size_; ++f) {
    const Index across = facets_[f].across;
    if (!(across & frozen_bit)) cells[across >> 2].v[0] &= vertex_mask;
  }
  for (std::size_t z = 0; z < zone_size_; ++z) cells[zone_[z] >> 2].v[0] &= vertex_mask;
  for (std::size_t i = 0; i < zone_vertices_size_; ++i) number_[zone_vertices_[i]] = 0;
  last_ = zone_[0] >> 2;
}

void Mesh::around(Vertex v, std::vector<Index>& found) const {
  if (v == newest_) {
    found.assign(slots_.begin(), slots_.begin() + static_cast<std::ptrdiff_t>(facets_size_));
    return;
  }
  found.assign(1, incident(v));
  // Marks last for this call only: a const mesh looks the same before and after.
  Cell* const all = const_cast<Cell*>(cells.data());
  all[found[0]].v[0] |= mark_in;
  for (std::size_t k = 0; k < found.size(); ++k) {
    const Index slot = found[k];
    for (Index i = 0; i < 4; ++i) {
      if (all[slot].vertex(i) == v) continue;
      const Index next = all[slot].n[i] >> 2;
      if (all[next].v[0] > vertex_mask) continue;
      all[next].v[0] |= mark_in;
      found.push_back(next);
    }
  }
  for (const Index slot : found) all[slot].v[0] &= vertex_mask;
}

// A cell that is reached through a facet has exactly one vertex that the cell before it lacks.
void Mesh::neighbours_into(Vertex v, std::vector<Vertex>& vertices) const {
  reserve_numbers();
  std::uint8_t* const number = number_.data();
  const auto meet = [&](Vertex w) {
    if (number[w] == 0) vertices.push_back(w);
    number[w] = 1;
  };
  number[v] = number[infinite_vertex] = 1;
  // As in around(), marks last for this call only.
  Cell* const all = const_cast<Cell*>(cells.data());
  around_.assign(1, incident(v));
  for (Index i = 0; i < 4; ++i) meet(all[around_[0]].v[i]);
  all[around_[0]].v[0] |= mark_in;
  for (std::size_t k = 0; k < around_.size(); ++k) {
    const Cell& c = all[around_[k]];
    for (Index i = 0; i < 4; ++i) {
      Cell& next = all[c.n[i] >> 2];
      if (c.vertex(i) == v || next.marked()) continue;
      meet(next.v[c.n[i] & 3]);
      next.v[0] |= mark_in;
      around_.push_back(c.n[i] >> 2);
    }
  }
  for (const Index slot : around_) all[slot].v[0] &= vertex_mask;
  for (const Vertex w : vertices) number[w] = 0;
  number[v] = number[infinite_vertex] = 0;
}

void Mesh::reserve_numbers() const {
  if (number_.size() <= points.size()) number_.resize(number_.empty() ? points.size() + 64 : points.size() * 3 / 2);
}

void Mesh::release_scratch() {
  newest_ = none;
  zone_size_ = facets_size_ = zone_vertices_size_ = 0;
  flat::release(zone_, pending_, facets_, slots_, zone_vertices_, edges_, around_);
}

void Mesh::zone_into(std::vector<Vertex>& vertices) const {
  for (const Vertex v : zone_vertices()) {
    if (v != infinite_vertex) vertices.push_back(v);
  }
}

std::size_t Mesh::memory() const {
  return base_memory() + number_.capacity() +
         sizeof(Index) * (zone_.capacity() + pending_.capacity() + slots_.capacity() + zone_vertices_.capacity() +
                          around_.capacity()) +
         sizeof(Facet) * facets_.capacity() + sizeof(Edge) * edges_.capacity();
}

}  // namespace tessera::flat3

template class tessera::flat::MeshBase<tessera::flat3::Mesh, tessera::flat3::Cell>;
