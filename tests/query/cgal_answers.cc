#include "tests/query/cgal_answers.h"

#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Delaunay_triangulation_cell_base_3.h>
#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>
#include <CGAL/convex_hull_2.h>
#include <CGAL/intersections.h>
#include <CGAL/natural_neighbor_coordinates_2.h>
#include <CGAL/natural_neighbor_coordinates_3.h>

#include <algorithm>
#include <iterator>
#include <limits>

namespace tessera::test {
namespace {

using K = CGAL::Exact_predicates_inexact_constructions_kernel;
using E = CGAL::Exact_predicates_exact_constructions_kernel;
using Dt2 = CGAL::Delaunay_triangulation_2<
    E, CGAL::Triangulation_data_structure_2<CGAL::Triangulation_vertex_base_with_info_2<PointId, E>>>;
using Dt3 = CGAL::Delaunay_triangulation_3<
    E, CGAL::Triangulation_data_structure_3<CGAL::Triangulation_vertex_base_with_info_3<PointId, E>,
                                            CGAL::Delaunay_triangulation_cell_base_3<E>>>;

E::Point_2 e2(const Point& p) { return {p.x, p.y}; }
E::Point_3 e3(const Point& p) { return {p.x, p.y, p.z}; }

// CGAL::to_double() alone is good for five digits.
double exactly(const E::FT& number) { return CGAL::to_double(number.exact()); }

template <class List>
std::vector<std::pair<PointId, double>> normalised(const List& found, const E::FT& all) {
  std::vector<std::pair<PointId, double>> weights;
  for (const auto& [vertex, part] : found) weights.emplace_back(vertex->info(), exactly(part / all));
  std::sort(weights.begin(), weights.end());
  return weights;
}

}  // namespace

struct CgalAnswers::Impl {
  Dt2 flat;
  Dt3 space;
};

CgalAnswers::CgalAnswers(const std::vector<Point>& points, int dimension) : impl_(std::make_unique<Impl>()) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (dimension == 2) impl_->flat.insert(e2(points[i]))->info() = PointId{i};
    if (dimension == 3) impl_->space.insert(e3(points[i]))->info() = PointId{i};
  }
}
CgalAnswers::~CgalAnswers() = default;

double CgalAnswers::voronoi_volume(PointId id) const {
  constexpr double inf = std::numeric_limits<double>::infinity();
  for (const auto v : impl_->flat.finite_vertex_handles()) {
    if (v->info() != id) continue;
    std::vector<E::Point_2> centres, hull;
    auto face = impl_->flat.incident_faces(v);
    const auto first = face;
    do {
      if (impl_->flat.is_infinite(face)) return inf;
      centres.push_back(impl_->flat.dual(face));
    } while (++face != first);
    CGAL::convex_hull_2(centres.begin(), centres.end(), std::back_inserter(hull));
    return exactly(CGAL::Polygon_2<E>(hull.begin(), hull.end()).area());
  }
  for (const auto v : impl_->space.finite_vertex_handles()) {
    if (v->info() != id) continue;
    std::vector<Dt3::Cell_handle> cells;
    impl_->space.incident_cells(v, std::back_inserter(cells));
    Dt3 hull;
    for (const auto cell : cells) {
      if (impl_->space.is_infinite(cell)) return inf;
      hull.insert(impl_->space.dual(cell));
    }
    E::FT volume = 0;
    for (const auto cell : hull.finite_cell_handles()) volume += hull.tetrahedron(cell).volume();
    return exactly(volume);
  }
  return 0;
}

std::vector<std::pair<PointId, double>> CgalAnswers::natural(const Point& q) const {
  if (impl_->flat.number_of_vertices() > 0) {
    std::vector<std::pair<Dt2::Vertex_handle, E::FT>> found;
    const auto result = CGAL::natural_neighbor_coordinates_2(impl_->flat, e2(q), std::back_inserter(found),
                                                             CGAL::Identity<std::pair<Dt2::Vertex_handle, E::FT>>());
    if (!result.third) return {};
    return normalised(found, result.second);
  }
  std::vector<std::pair<Dt3::Vertex_handle, E::FT>> found;
  E::FT all;
  const auto result = CGAL::sibson_natural_neighbor_coordinates_3(impl_->space, e3(q), std::back_inserter(found), all);
  if (!result.third) return {};
  return normalised(found, all);
}

bool cgal_meets(std::span<const Point> cell, const Bounds& box) {
  if (cell.size() == 3)
    return CGAL::do_intersect(E::Iso_rectangle_2(e2(box.lo), e2(box.hi)),
                              E::Triangle_2(e2(cell[0]), e2(cell[1]), e2(cell[2])));
  return CGAL::do_intersect(E::Iso_cuboid_3(e3(box.lo), e3(box.hi)),
                            E::Tetrahedron_3(e3(cell[0]), e3(cell[1]), e3(cell[2]), e3(cell[3])));
}

bool cgal_meets(std::span<const Point> triangle, const std::vector<Point>& ring) {
  CGAL::Polygon_2<E> polygon;
  for (const Point& p : ring) polygon.push_back(e2(p));
  const E::Triangle_2 whole(e2(triangle[0]), e2(triangle[1]), e2(triangle[2]));
  for (int k = 0; k < 3; ++k)
    if (polygon.bounded_side(whole.vertex(k)) != CGAL::ON_UNBOUNDED_SIDE) return true;
  return std::any_of(polygon.edges_begin(), polygon.edges_end(),
                     [&](const E::Segment_2& edge) { return CGAL::do_intersect(edge, whole); });
}

}  // namespace tessera::test
