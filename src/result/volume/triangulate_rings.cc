#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_face_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "src/result/volume/polygons.h"

namespace tessera::volume {
namespace {

using K = CGAL::Exact_predicates_inexact_constructions_kernel;
using Vertex = CGAL::Triangulation_vertex_base_with_info_2<double, K>;  // the height
// How many rings are around the triangle; -1: not known yet.
using Face = CGAL::Constrained_triangulation_face_base_2<K, CGAL::Triangulation_face_base_with_info_2<int, K>>;
using Cdt = CGAL::Constrained_Delaunay_triangulation_2<K, CGAL::Triangulation_data_structure_2<Vertex, Face>,
                                                       CGAL::No_constraint_intersection_requiring_constructions_tag>;

Status add_ring(Cdt& cdt, const std::vector<Point>& ring) {
  std::vector<Cdt::Vertex_handle> handles;
  for (const Point& p : ring) {
    const std::size_t before = cdt.number_of_vertices();
    const auto vertex = cdt.insert(K::Point_2(p.x, p.y));
    if (cdt.number_of_vertices() > before)
      vertex->info() = p.z;
    else if (vertex->info() != p.z)
      return error(Errc::bad_input, "has two vertices at one place with different heights");
    handles.push_back(vertex);
  }
  for (std::size_t i = 0; i < handles.size(); ++i) {
    const auto from = handles[i], to = handles[(i + 1) % handles.size()];
    if (from != to) cdt.insert_constraint(from, to);
  }
  return success();
}

// Counts the rings around each triangle, from the outside inwards.
void count_rings(Cdt& cdt) {
  for (auto face = cdt.all_faces_begin(); face != cdt.all_faces_end(); ++face) face->info() = -1;
  std::vector<Cdt::Face_handle> here{cdt.infinite_face()}, inwards;
  for (int depth = 0; !here.empty(); ++depth) {
    while (!here.empty()) {
      const auto face = here.back();
      here.pop_back();
      if (face->info() >= 0) continue;
      face->info() = depth;
      for (int k = 0; k < 3; ++k)
        if (face->neighbor(k)->info() < 0) (face->is_constrained(k) ? inwards : here).push_back(face->neighbor(k));
    }
    std::swap(here, inwards);
  }
}

}  // namespace

Result<std::vector<Facet>> triangulate_rings(const std::vector<std::vector<Point>>& rings) {
  Cdt cdt;
  try {
    for (const auto& ring : rings) {
      BOOST_OUTCOME_TRYV(add_ring(cdt, ring));
    }
  } catch (const Cdt::Intersection_of_constraints_exception&) {
    return error(Errc::bad_input, "is not valid: its edges cross each other");
  }
  std::vector<Facet> facets;
  if (cdt.dimension() < 2) return facets;
  count_rings(cdt);
  for (auto face = cdt.finite_faces_begin(); face != cdt.finite_faces_end(); ++face) {
    if (face->info() % 2 == 0) continue;
    Facet facet;
    for (int k = 0; k < 3; ++k) {
      const auto& p = face->vertex(k)->point();
      facet[static_cast<std::size_t>(k)] = {p.x(), p.y(), face->vertex(k)->info()};
    }
    facets.push_back(canonical(facet));
  }
  std::sort(facets.begin(), facets.end());
  return facets;
}

}  // namespace tessera::volume
