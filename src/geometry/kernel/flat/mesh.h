// What the triangulations of the flat kernels, flat2::Mesh and flat3::Mesh, have in common: points, slots with cells,
// the first simplex, and insertion and removal in terms of functions that each Mesh defines. A mesh knows no labels.
// Properties between any two calls:
//  (1) The cells are the perturbed Delaunay triangulation of the vertices, infinite cells included, without the frozen
//      cells.
//  (2) No cell is marked.
// Insertion is the algorithm of Bowyer and Watson: walk to a cell in conflict with the point, collect the connected
// conflict zone, and replace the zone by cells that join its boundary to the point.
//
// A Mesh also has:
//   add(p)                  adds a point and returns its number
//   spans_more(p)           whether p is affinely independent of the simplex so far
//   positive(simplex)       whether d + 1 vertices are positively oriented
//   walk(p, slot, found)    locates p from slot; false if frozen cells block every side that faces p
//   conflicts(p, slot)      whether p is in conflict with a cell, which may be marked: exact and perturbed
//   find_zone(p, slot)      collects the conflict zone of p from a cell in it; fill() or leave() must follow
//   zone_size(), zone_cell(i), zone_into(vertices)   the cells of the zone; its finite vertices, each once
//   fill(v)                 replaces the zone by cells that join its boundary to v; v is the point of the zone
//   leave()                 forgets the zone; the next walk starts there
//   around(v, found)        the cells around v; none of them may be frozen
//   neighbours_into(v, vertices)   the finite vertices of those cells except v, each once
//   release_scratch()       gives back the scratch memory of find_zone() and fill(), and forgets the zone
//   memory()                bytes on the heap
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "src/geometry/kernel/flat/cells.h"
#include "src/geometry/kernel/flat/flat_kernel.h"
#include "src/geometry/kernel/flat/memory.h"
#include "src/geometry/kernel/flat/nearby.h"
#include "src/geometry/kernel/flat/points.h"

namespace tessera::flat {

template <class Mesh, class CellType>
class MeshBase {
 public:
  using Cell = CellType;
  static constexpr int dimension = Cell::dimension;
  static constexpr Index corners = Cell::corners;
  using Corners = std::array<Vertex, corners>;

  Points points;
  Array<Cell> cells;

  // Removes the cells and the simplex, and keeps the points.
  void drop_cells();
  // The number of vertices of the simplex, less one. -1: no vertex. 0: one. 1: all are collinear so far, and so on.
  int spanned() const { return spanned_; }
  // Adds v to the simplex if the simplex then spans more.
  void extend_simplex(Vertex v);
  bool in_simplex(Vertex v) const;
  // Makes the cells of the simplex. REQUIRES: spanned() == dimension, no cells.
  void start();

  // Finds a cell in conflict with p, or the vertex at p. REQUIRES: there are cells.
  Located locate(const Point& p) const;
  // Inserts vertex v, the point of which is already in `points`.
  void insert(Vertex v);
  // Removes a vertex. Returns false and changes nothing if the other vertices span less. REQUIRES: none of the vertex's
  // cells and of their neighbours is frozen.
  bool remove(Vertex v);

  // Becomes a copy of a mesh without frozen cells.
  void copy(const Mesh& other);
  // Moves the cells out of the mesh. adopt() must follow.
  Array<Cell> take_cells();
  // Replaces the cells by `others`, cells of the same vertices. `frozen` is the number of cells that were handed out
  // and are not in `others`.
  void adopt(Array<Cell> others, Index frozen);
  Index frozen() const { return frozen_; }
  // Moves the last cells into the free slots. No slot is free afterwards. Slot numbers change.
  void compact();
  Index most_cells() const { return cells_max_; }
  std::size_t live_cells() const { return cells.size() - free_.size(); }
  std::span<const Index> free_slots() const { return free_; }

 protected:
  MeshBase(const FlatOptions& options, Vertex vertices_max)
      : points(std::min(options.vertices_max, vertices_max)), cells_max_(std::min(options.cells_max, cells_max)) {}
  const Point& corner(std::size_t i) const { return points[simplex_[i]]; }
  Index new_slot();
  // before_zone() is called before a zone is collected, and after_zone() afterwards with the number of its cells. An
  // unusually large zone leaves scratch memory of its size. The mesh releases this memory after some zones of usual
  // size. While large zones keep coming the memory stays.
  void before_zone();
  void after_zone(std::size_t size) {
    if (size > usual_zone) [[unlikely]]
      usual_left_ = usual_zones;
  }
  // Returns a cell around v. REQUIRES: v is alive.
  Index incident(Vertex v) const;
  std::size_t base_memory() const;

  Index cells_max_;    // KernelFull is thrown beyond so many cells
  Corners simplex_{};  // spanned_ + 1 vertices; points of removed vertices stay known
  int spanned_ = -1;
  std::vector<Index> free_;  // slots without a cell
  Index frozen_ = 0;         // the number of frozen cells
  mutable Index last_ =
      0;  // a cell of the last insertion or the last vertex asked for; the next point is probably near
  static constexpr Vertex none = ~Vertex{0};
  Vertex newest_ = none;                           // the vertex that was inserted last, if nothing has changed since
  static constexpr std::size_t usual_zone = 4096;  // cells; a larger zone is unusual; a zone of uniform points has 21

 private:
  Mesh& self() { return static_cast<Mesh&>(*this); }
  const Mesh& self() const { return static_cast<const Mesh&>(*this); }
  static constexpr Index usual_zones = 64;
  Index usual_left_ = 0;  // zones until scratch is released; 0: nothing to release

  mutable NearbyCells<Cell::dimension> nearby_;  // a sample of the cells
  mutable std::size_t nearby_of_ = 0;            // cells when the sample was made; at twice as many it is made again

  std::vector<Index> nearby(const Point& p) const;
  Located search(const Point& p, const std::vector<Index>& starts) const;
};

}  // namespace tessera::flat
