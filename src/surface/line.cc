#include "src/surface/line.h"

#include "src/geometry/predicates/exact/predicates.h"

namespace tessera::surface {

namespace {

// (a - o) x (b - o) has three components, which the perturbation multiplies by e, e^2 and e^3. Returns the sign of the
// first that is not 0. The components are orientations of the points, seen along the axes.
int first_component(const Point& o, const Point& a, const Point& b) {
  const auto along_x = [](const Point& q) { return Point{q.y, q.z, 0}; };
  if (const int sign = exact::orientation_2(along_x(o), along_x(a), along_x(b)); sign != 0) return sign;
  const auto along_y = [](const Point& q) { return Point{q.z, q.x, 0}; };
  if (const int sign = exact::orientation_2(along_y(o), along_y(a), along_y(b)); sign != 0) return sign;
  return exact::orientation_2(o, a, b);
}

}  // namespace

// The determinant is the dot product of s - p and (a - p) x (b - p).
int side_of_line(const Point& p, const Point& s, const Point& a, const Point& b) {
  const int sign = exact::orientation_3(p, s, a, b);
  return sign != 0 ? sign : first_component(p, a, b);
}

bool is_beyond(const Point& a, const Point& b, const Point& c, const Point& s) {
  const int sign = exact::orientation_3(a, b, c, s);
  return (sign != 0 ? sign : first_component(a, b, c)) > 0;
}

}  // namespace tessera::surface
