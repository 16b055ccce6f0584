#include "bench/engine/cgal_sequential.h"

#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <chrono>

namespace tessera {

CgalTime cgal_sequential(const std::vector<Point>& points, int dimension) {
  using K = CGAL::Exact_predicates_inexact_constructions_kernel;
  CgalTime out;
  const auto measure = [&](auto&& build) {
    const auto begin = std::chrono::steady_clock::now();
    out.cells = build();
    out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  if (dimension == 3) {
    std::vector<K::Point_3> list;
    list.reserve(points.size());
    for (const Point& p : points) list.emplace_back(p.x, p.y, p.z);
    CGAL::Delaunay_triangulation_3<K> t;
    measure([&] {
      t.insert(list.begin(), list.end());
      return t.number_of_finite_cells();
    });
  } else {
    std::vector<K::Point_2> list;
    list.reserve(points.size());
    for (const Point& p : points) list.emplace_back(p.x, p.y);
    CGAL::Delaunay_triangulation_2<K> t;
    measure([&] {
      t.insert(list.begin(), list.end());
      return t.number_of_faces();
    });
  }
  return out;
}

}  // namespace tessera
