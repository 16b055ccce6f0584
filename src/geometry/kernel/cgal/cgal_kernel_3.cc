#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Delaunay_triangulation_cell_base_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>

#include <array>
#include <cassert>
#include <iterator>
#include <utility>

#include "src/geometry/kernel/cgal/cgal_kernel_impl.h"
#include "src/geometry/kernel/cgal/cgal_kernels.h"

namespace tessera {
namespace {

using K = CGAL::Exact_predicates_inexact_constructions_kernel;

using VertexBase = CGAL::Triangulation_vertex_base_with_info_3<Vertex, K>;
using Tds = CGAL::Triangulation_data_structure_3<VertexBase, Indexed<CGAL::Delaunay_triangulation_cell_base_3<K>>>;
// The number and the mark fit into the padding behind CGAL's conflict mark.
static_assert(sizeof(Tds::Cell) == 72 && sizeof(Tds::Vertex) == 48);

struct Traits3 {
  using Triangulation = CGAL::Delaunay_triangulation_3<K, Tds>;
  using Vertex_h = Triangulation::Vertex_handle;
  using Cell = Triangulation::Cell_handle;
  static constexpr int d = 3;

  static K::Point_3 to_cgal(const Point& p) { return {p.x, p.y, p.z}; }
  static Point from_cgal(const K::Point_3& p) { return {p.x(), p.y(), p.z()}; }
  static Cell cell_of(Vertex_h v) { return v->cell(); }
  static void set_cell_of(Vertex_h v, Cell c) { v->set_cell(c); }

  template <class F>
  static void for_each_cell(const Triangulation& t, F f) {
    for (auto c = t.all_cells_begin(); c != t.all_cells_end(); ++c) f(Cell(c));
  }
  template <class F>
  static void for_each_incident_cell(const Triangulation& t, Vertex_h v, F f) {
    thread_local std::vector<Cell> cells;
    cells.clear();
    t.incident_cells(v, std::back_inserter(cells));
    for (const Cell c : cells) f(c);
  }
  template <class F>
  static void for_each_neighbour(const Triangulation& t, Vertex_h v, F f) {
    thread_local std::vector<Vertex_h> around;
    around.clear();
    t.finite_adjacent_vertices(v, std::back_inserter(around));
    for (const Vertex_h w : around) f(w);
  }

  struct Zone {
    std::vector<Cell> cells;
    std::vector<Triangulation::Facet> boundary;
    void clear() {
      cells.clear();
      boundary.clear();
    }
  };
  static Vertex_h conflicts(const Triangulation& t, const K::Point_3& p, Cell start, Zone& zone) {
    Triangulation::Locate_type type;
    int i = 0, j = 0;
    const Cell c = t.locate(p, type, i, j, start);
    if (type == Triangulation::VERTEX) return c->vertex(i);
    t.find_conflicts(p, c, std::back_inserter(zone.boundary), std::back_inserter(zone.cells));
    return {};
  }
  // Makes sure that an insertion into a small hole allocates no cells. CGAL 5.5 fills a small hole through a table that
  // belongs to the thread. An exception in the middle leaves the hole's edges in the table, and the next triangulation
  // in this thread takes them for its own.
  static void make_room(Triangulation& t) {
    constexpr std::size_t small_hole_cells = 128;
    auto& tds = t.tds();
    assert(tds.is_small_hole(small_hole_cells) && !tds.is_small_hole(small_hole_cells + 1));
    if (tds.cells().capacity() - tds.cells().size() >= small_hole_cells) return;
    std::array<Cell, small_hole_cells> made;
    for (Cell& cell : made) cell = tds.create_cell();
    for (auto cell = made.rbegin(); cell != made.rend(); ++cell) tds.delete_cell(*cell);
  }
  // Inserts as CGAL does: a small hole is filled through a table of its edges, a large one by turning around its edges.
  static Vertex_h insert_into(Triangulation& t, const K::Point_3& p, const Zone& zone) {
    if (!t.tds().is_small_hole(zone.boundary.size())) {
      const auto& [cell, i] = zone.boundary.front();
      return t.insert_in_hole(p, zone.cells.begin(), zone.cells.end(), cell, i);
    }
    const Vertex_h v = t.tds()._insert_in_small_hole(zone.cells, zone.boundary);
    v->set_point(p);
    return v;
  }

  template <class T>
  static Cell create_cell(T& tds, const std::array<Vertex_h, 4>& v) {
    return tds.create_cell(v[0], v[1], v[2], v[3]);
  }
  static void set_neighbours(Cell c, const std::array<Cell, 4>& n) { c->set_neighbors(n[0], n[1], n[2], n[3]); }
  static std::size_t memory(const Triangulation& t) {
    return t.tds().cells().capacity() * sizeof(Tds::Cell) + t.tds().vertices().capacity() * sizeof(Tds::Vertex);
  }
};

}  // namespace

std::unique_ptr<Kernel> make_cgal_kernel_3() { return std::make_unique<CgalKernel<Traits3>>(); }

}  // namespace tessera
