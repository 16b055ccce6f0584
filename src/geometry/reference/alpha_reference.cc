#include "src/geometry/reference/alpha_reference.h"

#include <CGAL/Alpha_shape_2.h>
#include <CGAL/Alpha_shape_3.h>
#include <CGAL/Alpha_shape_cell_base_3.h>
#include <CGAL/Alpha_shape_face_base_2.h>
#include <CGAL/Alpha_shape_vertex_base_2.h>
#include <CGAL/Alpha_shape_vertex_base_3.h>
#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace tessera {

namespace {

using K = CGAL::Exact_predicates_exact_constructions_kernel;
using Vb2 = CGAL::Alpha_shape_vertex_base_2<K, CGAL::Triangulation_vertex_base_with_info_2<PointId, K>>;
using Dt2 =
    CGAL::Delaunay_triangulation_2<K, CGAL::Triangulation_data_structure_2<Vb2, CGAL::Alpha_shape_face_base_2<K>>>;
using Shape2 = CGAL::Alpha_shape_2<Dt2>;
using Vb3 = CGAL::Alpha_shape_vertex_base_3<K, CGAL::Triangulation_vertex_base_with_info_3<PointId, K>>;
using Cb3 = CGAL::Alpha_shape_cell_base_3<K, CGAL::Delaunay_triangulation_cell_base_3<K>>;
using Dt3 = CGAL::Delaunay_triangulation_3<K, CGAL::Triangulation_data_structure_3<Vb3, Cb3>>;
using Shape3 = CGAL::Alpha_shape_3<Dt3>;

K::FT square(double radius) { return K::FT(radius) * K::FT(radius); }

// The least double whose square is at least alpha.
double root_up(const K::FT& alpha) {
  double root = std::sqrt(CGAL::to_double(alpha));
  const double infinite = std::numeric_limits<double>::infinity();
  while (square(root) < alpha) root = std::nextafter(root, infinite);
  while (root > 0 && square(std::nextafter(root, 0)) >= alpha) root = std::nextafter(root, 0);
  return root;
}

template <class Handle>
std::vector<PointId> face_of(std::initializer_list<Handle> vertices) {
  std::vector<PointId> ids;
  for (const Handle& v : vertices) ids.push_back(v->info());
  std::sort(ids.begin(), ids.end());
  return ids;
}

void read(const Shape2& shape, const K::FT& alpha, ReferenceShape& to) {
  for (auto e = shape.finite_edges_begin(); e != shape.finite_edges_end(); ++e) {
    const auto kind = shape.classify(*e, alpha);
    auto ids = face_of({e->first->vertex(Shape2::cw(e->second)), e->first->vertex(Shape2::ccw(e->second))});
    if (kind == Shape2::REGULAR)
      to.facets.push_back(std::move(ids));
    else if (kind == Shape2::SINGULAR)
      to.singular_facets.push_back(std::move(ids));
  }
  for (auto v = shape.finite_vertices_begin(); v != shape.finite_vertices_end(); ++v)
    if (shape.classify(Shape2::Vertex_handle(v), alpha) == Shape2::SINGULAR)
      to.singular_vertices.push_back({v->info()});
}

void read(const Shape3& shape, const K::FT& alpha, ReferenceShape& to) {
  for (auto f = shape.finite_facets_begin(); f != shape.finite_facets_end(); ++f) {
    const auto kind = shape.classify(*f, alpha);
    const auto vertex = [&](int i) { return f->first->vertex((f->second + i) & 3); };
    auto ids = face_of({vertex(1), vertex(2), vertex(3)});
    if (kind == Shape3::REGULAR)
      to.facets.push_back(std::move(ids));
    else if (kind == Shape3::SINGULAR)
      to.singular_facets.push_back(std::move(ids));
  }
  for (auto e = shape.finite_edges_begin(); e != shape.finite_edges_end(); ++e)
    if (shape.classify(*e, alpha) == Shape3::SINGULAR)
      to.singular_edges.push_back(face_of({e->first->vertex(e->second), e->first->vertex(e->third)}));
  for (auto v = shape.finite_vertices_begin(); v != shape.finite_vertices_end(); ++v)
    if (shape.classify(Shape3::Vertex_handle(v), alpha) == Shape3::SINGULAR)
      to.singular_vertices.push_back({v->info()});
}

std::vector<std::pair<K::Point_2, PointId>> given(std::span<const LocalPoint> points, const Shape2*) {
  std::vector<std::pair<K::Point_2, PointId>> list;
  for (const LocalPoint& p : points) list.emplace_back(K::Point_2(p.at.x, p.at.y), p.id);
  return list;
}
std::vector<std::pair<K::Point_3, PointId>> given(std::span<const LocalPoint> points, const Shape3*) {
  std::vector<std::pair<K::Point_3, PointId>> list;
  for (const LocalPoint& p : points) list.emplace_back(K::Point_3(p.at.x, p.at.y, p.at.z), p.id);
  return list;
}

}  // namespace

struct AlphaReference::Impl {
  virtual ~Impl() = default;
  virtual ReferenceShape at(double radius) = 0;
  virtual bool is_one_piece(double radius) = 0;
  virtual double least_radius() = 0;
  virtual double optimal_radius() = 0;
};

template <class Shape>
struct AlphaReference::ImplOf : AlphaReference::Impl {
  using Triangulation = typename Shape::Triangulation;
  explicit ImplOf(std::span<const LocalPoint> points)
      : list(given(points, static_cast<const Shape*>(nullptr))),
        triangulation(list.begin(), list.end()),
        shape(triangulation, K::FT(0), Shape::GENERAL) {}
  ReferenceShape at(double radius) override {
    ReferenceShape found;
    read(shape, square(radius), found);
    for (IdFaces* faces : {&found.facets, &found.singular_facets, &found.singular_edges, &found.singular_vertices})
      std::sort(faces->begin(), faces->end());
    return found;
  }
  double least_radius() override {
    double last = 0;  // many alphas may have the same root
    for (auto alpha = shape.alpha_lower_bound(shape.find_alpha_solid()); alpha != shape.alpha_end(); ++alpha) {
      const double radius = root_up(*alpha);
      if (radius != last && is_one_piece(radius)) return radius;
      last = radius;
    }
    return 0;
  }
  bool is_one_piece(double radius) override {
    return square(radius) >= shape.find_alpha_solid() && shape.number_of_solid_components(square(radius)) == 1;
  }
  double optimal_radius() override { return root_up(*shape.find_optimal_alpha(1)); }

  decltype(given({}, static_cast<const Shape*>(nullptr))) list;
  Triangulation triangulation;
  Shape shape;
};

AlphaReference::AlphaReference(std::span<const LocalPoint> points, int dimension) {
  if (dimension == 2) {
    impl_ = std::make_unique<ImplOf<Shape2>>(points);
  } else {
    impl_ = std::make_unique<ImplOf<Shape3>>(points);
  }
}
AlphaReference::~AlphaReference() = default;

ReferenceShape AlphaReference::at(double radius) const { return impl_->at(radius); }
bool AlphaReference::is_one_piece(double radius) const { return impl_->is_one_piece(radius); }
double AlphaReference::least_radius() const { return impl_->least_radius(); }
double AlphaReference::optimal_radius() const { return impl_->optimal_radius(); }

}  // namespace tessera
