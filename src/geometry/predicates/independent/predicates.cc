// Ties follow Devillers & Teillaud, Perturbations and vertex removal in a 3D Delaunay triangulation, SODA 2003. The
// rule is written out here and not borrowed from CGAL's triangulation, because verify must not repeat the engine's own
// code.
#include "src/base/ieee_arithmetic.h"  // first, so that the compiler refuses unsafe flags at once

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <array>

#include "src/geometry/predicates/independent/predicates.h"

namespace tessera::independent {
namespace {

using K = CGAL::Exact_predicates_inexact_constructions_kernel;
K::Point_3 c3(const Point& p) { return {p.x, p.y, p.z}; }
K::Point_2 c2(const Point& p) { return {p.x, p.y}; }

}  // namespace

int orientation_3(const Point& a, const Point& b, const Point& c, const Point& d) {
  return CGAL::orientation(c3(a), c3(b), c3(c), c3(d));
}

int orientation_2(const Point& a, const Point& b, const Point& c) { return CGAL::orientation(c2(a), c2(b), c2(c)); }

bool collinear_3(const Point& a, const Point& b, const Point& c) { return CGAL::collinear(c3(a), c3(b), c3(c)); }

// The perturbation lifts the lexicographically greatest point by the largest infinitesimal, the next point by a smaller
// one, and so on. So the greatest point whose lift matters decides. If this point is the query, the query rises out of
// the sphere. If it is a vertex, the sphere bends towards or away from the query; the orientation with the query in the
// vertex's place says which.
int in_sphere_perturbed_3(const Point& a, const Point& b, const Point& c, const Point& d, const Point& e) {
  if (const int side = CGAL::side_of_oriented_sphere(c3(a), c3(b), c3(c), c3(d), c3(e)); side != 0) return side;
  const std::array<const Point*, 4> cell{&a, &b, &c, &d};
  std::array<const Point*, 5> order{&a, &b, &c, &d, &e};
  std::sort(order.begin(), order.end(), [](const Point* p, const Point* q) { return *p > *q; });
  for (const Point* greatest : order) {
    if (greatest == &e) return -1;
    std::array<const Point*, 4> with = cell;
    std::replace(with.begin(), with.end(), greatest, &e);
    if (const int side = orientation_3(*with[0], *with[1], *with[2], *with[3]); side != 0) return side;
  }
  return 0;
}

int in_circle_perturbed_2(const Point& a, const Point& b, const Point& c, const Point& d) {
  if (const int side = CGAL::side_of_oriented_circle(c2(a), c2(b), c2(c), c2(d)); side != 0) return side;
  const std::array<const Point*, 3> cell{&a, &b, &c};
  std::array<const Point*, 4> order{&a, &b, &c, &d};
  const auto greater = [](const Point* p, const Point* q) { return p->x != q->x ? p->x > q->x : p->y > q->y; };
  std::sort(order.begin(), order.end(), greater);
  for (const Point* greatest : order) {
    if (greatest == &d) return -1;
    std::array<const Point*, 3> with = cell;
    std::replace(with.begin(), with.end(), greatest, &d);
    if (const int side = orientation_2(*with[0], *with[1], *with[2]); side != 0) return side;
  }
  return 0;
}

}  // namespace tessera::independent
