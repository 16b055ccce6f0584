#include "bench/live/cgal_batches.h"

#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

namespace tessera {
namespace {

using K = CGAL::Exact_predicates_inexact_constructions_kernel;

}  // namespace

struct CgalBatches::Impl {
  int dimension;
  CGAL::Delaunay_triangulation_2<K> in_2d;
  CGAL::Delaunay_triangulation_3<K> in_3d;
};

CgalBatches::CgalBatches(const std::vector<Point>& points, int dimension)
    : impl_(std::make_unique<Impl>(Impl{dimension, {}, {}})) {
  insert(points);
}
CgalBatches::~CgalBatches() = default;

void CgalBatches::insert(const std::vector<Point>& points) {
  if (impl_->dimension == 2) {
    std::vector<K::Point_2> list;
    for (const Point& p : points) list.emplace_back(p.x, p.y);
    impl_->in_2d.insert(list.begin(), list.end());
  } else {
    std::vector<K::Point_3> list;
    for (const Point& p : points) list.emplace_back(p.x, p.y, p.z);
    impl_->in_3d.insert(list.begin(), list.end());
  }
}

}  // namespace tessera
