#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_face_base_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <iterator>

#include "src/geometry/kernel/cgal/cgal_kernel_impl.h"
#include "src/geometry/kernel/cgal/cgal_kernels.h"

namespace tessera {
namespace {

using K = CGAL::Exact_predicates_inexact_constructions_kernel;

using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<Vertex, K>;
using Tds = CGAL::Triangulation_data_structure_2<VertexBase, Indexed<CGAL::Triangulation_face_base_2<K>>>;

struct Traits2 {
  using Triangulation = CGAL::Delaunay_triangulation_2<K, Tds>;
  using Vertex_h = Triangulation::Vertex_handle;
  using Cell = Triangulation::Face_handle;
  static constexpr int d = 2;

  static K::Point_2 to_cgal(const Point& p) { return {p.x, p.y}; }
  static Point from_cgal(const K::Point_2& p) { return {p.x(), p.y(), 0}; }
  static Cell cell_of(Vertex_h v) { return v->face(); }
  static void set_cell_of(Vertex_h v, Cell c) { v->set_face(c); }

  template <class F>
  static void for_each_cell(const Triangulation& t, F f) {
    for (auto c = t.all_faces_begin(); c != t.all_faces_end(); ++c) f(Cell(c));
  }
  template <class F>
  static void for_each_incident_cell(const Triangulation& t, Vertex_h v, F f) {
    const auto begin = t.incident_faces(v);
    auto c = begin;
    do {
      f(Cell(c));
    } while (++c != begin);
  }
  template <class F>
  static void for_each_neighbour(const Triangulation& t, Vertex_h v, F f) {
    auto w = t.incident_vertices(v);
    if (w == nullptr) return;
    const auto begin = w;
    do {
      if (!t.is_infinite(w)) f(Vertex_h(w));
    } while (++w != begin);
  }

  struct Zone {
    std::vector<Cell> cells;
    void clear() { cells.clear(); }
  };
  static Vertex_h conflicts(const Triangulation& t, const K::Point_2& p, Cell start, Zone& zone) {
    Triangulation::Locate_type type;
    int i = 0;
    const Cell c = t.locate(p, type, i, start);
    if (type == Triangulation::VERTEX) return c->vertex(i);
    t.get_conflicts(p, std::back_inserter(zone.cells), c);
    return {};
  }
  static void make_room(Triangulation&) {}
  static Vertex_h insert_into(Triangulation& t, const K::Point_2& p, const Zone& zone) {
    return t.insert(p, zone.cells.front());
  }

  template <class T>
  static Cell create_cell(T& tds, const std::array<Vertex_h, 3>& v) {
    return tds.create_face(v[0], v[1], v[2]);
  }
  static void set_neighbours(Cell c, const std::array<Cell, 3>& n) { c->set_neighbors(n[0], n[1], n[2]); }
  static std::size_t memory(const Triangulation& t) {
    return t.tds().faces().capacity() * sizeof(Tds::Face) + t.tds().vertices().capacity() * sizeof(Tds::Vertex);
  }
};

}  // namespace

std::unique_ptr<Kernel> make_cgal_kernel_2() { return std::make_unique<CgalKernel<Traits2>>(); }

}  // namespace tessera
