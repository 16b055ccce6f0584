// What the triangulations of the flat kernels, flat2::Mesh and flat3::Mesh, have in common: points, slots with cells,
// the simplex they begin with, insertion and removal in terms of what each does in its own way. Knows nothing of
// labels. Properties, between any two calls:
//  (1) The cells are the perturbed Delaunay triangulation of the vertices, infinite cells included, without those that
//      were frozen.
//  (2) No cell is marked.
// The insertion is Bowyer's and Watson's: walk to a cell in conflict, collect the connected conflict zone, put the
// cells that join its boundary to the point into its slots.
//
// A Mesh has besides:
//   add(p)                  one more point, and its number
//   spans_more(p)           whether p is affinely independent of the simplex so far
//   positive(simplex)       the orientation of d + 1 vertices
//   walk(p, slot, found)    false if frozen cells blocked the way on every side that faces p
//   conflicts(p, slot)      whether p is in conflict with a cell, which may be marked: exact and perturbed
//   find_zone(p, slot)      collects the conflict zone of p from a cell in it; to be followed by fill() or leave()
//   zone_size(), zone_cell(i), zone_into(vertices)   the cells of the zone; its finite vertices, each once
//   fill(v)                 joins the zone's boundary to v, whose zone it is
//   leave()                 forgets the zone; the next walk starts here
//   around(v, found)        the cells around v, none of them frozen
//   neighbours_into(v, vertices)   the finite vertices of those cells but v, each once
//   release_scratch()       gives back what find_zone() and fill() have grown; the zone is forgotten
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
  static constexpr Word corners = Cell::corners;
  using Corners = std::array<Vertex, corners>;

  Points points;
  Array<Cell> cells;

  // No cells, no simplex; the points stay.
  void drop_cells();
  // -1: no vertex; 0: one; 1: all collinear so far, and so on: how many vertices the simplex has, less one.
  int spanned() const { return spanned_; }
  // Takes v into the simplex, if it spans more with it.
  void span_more(Vertex v);
  bool in_simplex(Vertex v) const;
  // The cells of the simplex. REQUIRES: spanned() == dimension, no cells.
  void start();

  // Where p is. Ends at a cell in conflict with p, unless p is there already. REQUIRES: there are cells.
  Located locate(const Point& p) const;
  // Locates, finds and fills, for a point that is not there yet and is vertex v.
  void insert(Vertex v);
  // Takes a vertex out. False, and nothing is changed, if the others span less. REQUIRES: none of its cells or of their
  // neighbours is frozen.
  bool remove(Vertex v);

  // The cells, which leave the mesh until others come by adopt().
  Array<Cell> take_cells();
  // Other cells of the same vertices, without the `frozen` ones that have been handed out.
  void adopt(Array<Cell> others, Word frozen);
  Word frozen() const { return frozen_; }
  // Moves the last cells into free slots, so that there are none. Slot numbers change.
  void compact();
  Word most_cells() const { return cells_max_; }
  std::size_t live_cells() const { return cells.size() - free_.size(); }
  std::span<const Word> free_slots() const { return free_; }

 protected:
  MeshBase(const FlatOptions& options, Vertex vertices_max)
      : points(std::min(options.vertices_max, vertices_max)), cells_max_(std::min(options.cells_max, cells_max)) {}
  const Point& corner(std::size_t i) const { return points[simplex_[i]]; }
  Word new_slot();
  // To be called before a zone is collected and after, with its number of cells: a zone of unusual size leaves scratch
  // of its size, which goes when some usual ones have followed. Where all are large it stays.
  void before_zone();
  void after_zone(std::size_t size) {
    if (size > usual_zone) [[unlikely]]
      usual_left_ = usual_zones;
  }
  // A cell around v, which is alive.
  Word incident(Vertex v) const;
  std::size_t base_memory() const;

  Word cells_max_;     // more than so many: KernelFull
  Corners simplex_{};  // spanned_ + 1 vertices; their points stay known when they are removed
  int spanned_ = -1;
  std::vector<Word> free_;  // slots without a cell
  Word frozen_ = 0;         // cells that are gone
  mutable Word last_ = 0;   // where the last insertion was, or a vertex was last asked for: the next is near
  static constexpr Vertex none = ~Vertex{0};
  Vertex newest_ = none;                           // what was inserted last, if nothing has changed since
  static constexpr std::size_t usual_zone = 4096;  // cells, at most; a zone of uniform points has 21

 private:
  Mesh& self() { return static_cast<Mesh&>(*this); }
  const Mesh& self() const { return static_cast<const Mesh&>(*this); }
  static constexpr Word usual_zones = 64;
  Word usual_left_ = 0;  // zones until scratch is released, or 0

  mutable NearbyCells<Cell::dimension> nearby_;  // of those there were when it was last asked with twice as many
  mutable std::size_t nearby_of_ = 0;            // so many cells

  std::vector<Word> nearby(const Point& p) const;
  Located search(const Point& p, const std::vector<Word>& starts) const;
};

}  // namespace tessera::flat
