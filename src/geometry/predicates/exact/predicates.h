// Exact signs of the determinants of Delaunay triangulation, for every finite double: denormals, +-0, 1e300.
// Properties:
//  (1) The answer is the sign of the exact determinant of the given coordinates, never an estimate.
//  (2) The answer depends on coordinates alone; -0 equals 0.
// There are seven stages. Each is used only when the stage before cannot decide:
//  filter   floating point on differences to the last point, with an error bound (inline, in this header);
//  lattice  the differences are small multiples of a power of two, so that floating point does not round; or all points
//           have one coordinate in common;
//  integer  the differences are doubles without error, as among neighbours in quantised data: 64-bit integers times a
//           common power of two, with products of 128 to 320 bits;
//  wide     the coordinates themselves as 128-bit integers;
//  any_exponent  floating point with unbounded exponents and an error bound (any_exponent.h), for points whose
//           coordinates are of very different sizes;
//  axes     the coordinates as 128-bit integers times a power of two for each axis;
//  big      integers of any length.
// The error bounds hold for round-to-nearest, and code compiled without fused multiply-add.
// Functions with the suffix _2 read x and y only. All functions are safe to call from any thread.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "src/base/ieee_arithmetic.h"
#include "src/base/point.h"

namespace tessera::exact {

enum class PredicateStage : std::uint8_t { filter, lattice, integer, wide, any_exponent, axes, big };
// A sign with the stage that decided it, for tests and benchmarks.
struct Staged {
  int sign = 0;
  PredicateStage stage = PredicateStage::filter;
};

// The stages after the filter.
Staged orientation_2_exact(const Point& a, const Point& b, const Point& c);
Staged orientation_3_exact(const Point& a, const Point& b, const Point& c, const Point& d);
Staged in_circle_2_exact(const Point& a, const Point& b, const Point& c, const Point& d);
Staged in_sphere_3_exact(const Point& a, const Point& b, const Point& c, const Point& d, const Point& e);

// The error bounds. Let u = 2^-53. A computed difference has relative error u, and a product or sum adds a factor (1 +
// u). So a determinant whose terms pass k roundings each is off by at most k u (1 + tiny) times the sum of its terms'
// absolute values. This sum is bounded by products of the largest absolute difference per axis (mx, my, mz) and of the
// largest lift (the squared distance to the last point). The constants below are rounded up by 4 % or more. The reserve
// covers the rounding of mx, my and mz, and of the bound itself.
//   orientation_2    k = 4 (2 differences, product, sum); the sum is |l| + |r|                           4 u -> 5 u
//   orientation_3    k = 8 (3 differences, product, sum, product, 2 sums); 6 terms                      48 u -> 50 u
//   in_circle_2   k = 11 (4 differences, minor 2, lift 2, product, 2 sums); 6 terms                  66 u -> 70 u
//   in_sphere_3   k = 16 (5 differences, minor 5, lift 3, product, 2 sums); 24 terms                384 u -> 400 u
// A product that underflows is off by another 2^-1075, times its later factors. These are below 1e180, because
// differences are kept below 1e60. `underflow` covers all of that together. Larger differences, and overflow to
// infinity or NaN, are left to the exact stages.
namespace filter {
inline constexpr double u = 0x1p-53;
inline constexpr double underflow = 1e-130;
inline constexpr double lift_max = 1e120;
inline constexpr double difference_max = 1e60;

// Returns +1 or -1 when the sign is certain, else 0.
inline int sign_beyond(double value, double error) { return (value > error) - (value < -error); }
inline double max_abs(double a, double b) { return std::max(std::abs(a), std::abs(b)); }
inline double max_abs(double a, double b, double c) { return std::max(max_abs(a, b), std::abs(c)); }
inline double max_abs(double a, double b, double c, double d) { return std::max(max_abs(a, b), max_abs(c, d)); }

inline int orientation_2(const Point& a, const Point& b, const Point& c) {
  const double l = (a.x - c.x) * (b.y - c.y), r = (a.y - c.y) * (b.x - c.x);
  // An overflow makes the error infinite or NaN, so no sign is certain.
  return sign_beyond(l - r, 5 * u * (std::abs(l) + std::abs(r)) + underflow);
}

inline int orientation_3(const Point& a, const Point& b, const Point& c, const Point& d) {
  const double ax = a.x - d.x, ay = a.y - d.y, az = a.z - d.z;
  const double bx = b.x - d.x, by = b.y - d.y, bz = b.z - d.z;
  const double cx = c.x - d.x, cy = c.y - d.y, cz = c.z - d.z;
  const double det = az * (by * cx - bx * cy) + bz * (ax * cy - ay * cx) + cz * (ay * bx - ax * by);
  const double mx = max_abs(ax, bx, cx), my = max_abs(ay, by, cy), mz = max_abs(az, bz, cz);
  if (!(std::max(std::max(mx, my), mz) < difference_max)) return 0;
  return sign_beyond(det, 50 * u * (mx * my * mz) + underflow);
}

inline int in_circle_2(const Point& a, const Point& b, const Point& c, const Point& d) {
  const double ax = a.x - d.x, ay = a.y - d.y;
  const double bx = b.x - d.x, by = b.y - d.y;
  const double cx = c.x - d.x, cy = c.y - d.y;
  const double al = ax * ax + ay * ay, bl = bx * bx + by * by, cl = cx * cx + cy * cy;
  const double det = al * (bx * cy - by * cx) + bl * (cx * ay - cy * ax) + cl * (ax * by - ay * bx);
  const double lift = std::max(std::max(al, bl), cl);
  if (!(lift < lift_max)) return 0;
  return sign_beyond(det, 70 * u * (max_abs(ax, bx, cx) * max_abs(ay, by, cy) * lift) + underflow);
}

inline int in_sphere_3(const Point& a, const Point& b, const Point& c, const Point& d, const Point& e) {
  const double ax = a.x - e.x, ay = a.y - e.y, az = a.z - e.z;
  const double bx = b.x - e.x, by = b.y - e.y, bz = b.z - e.z;
  const double cx = c.x - e.x, cy = c.y - e.y, cz = c.z - e.z;
  const double dx = d.x - e.x, dy = d.y - e.y, dz = d.z - e.z;
  const double ab = ax * by - bx * ay, bc = bx * cy - cx * by, cd = cx * dy - dx * cy;
  const double da = dx * ay - ax * dy, ac = ax * cy - cx * ay, bd = bx * dy - dx * by;
  const double abc = az * bc - bz * ac + cz * ab;
  const double bcd = bz * cd - cz * bd + dz * bc;
  const double cda = cz * da + dz * ac + az * cd;
  const double dab = dz * ab + az * bd + bz * da;
  const double al = ax * ax + ay * ay + az * az, bl = bx * bx + by * by + bz * bz;
  const double cl = cx * cx + cy * cy + cz * cz, dl = dx * dx + dy * dy + dz * dz;
  const double det = (al * bcd - bl * cda) + (cl * dab - dl * abc);
  const double lift = std::max(std::max(al, bl), std::max(cl, dl));
  if (!(lift < lift_max)) return 0;
  const double volume = max_abs(ax, bx, cx, dx) * max_abs(ay, by, cy, dy) * max_abs(az, bz, cz, dz);
  return sign_beyond(det, 400 * u * (volume * lift) + underflow);
}
}  // namespace filter

// Each predicate below, with the stage that decided.
inline Staged orientation_2_staged(const Point& a, const Point& b, const Point& c) {
  const int sign = filter::orientation_2(a, b, c);
  return sign != 0 ? Staged{sign, PredicateStage::filter} : orientation_2_exact(a, b, c);
}
inline Staged orientation_3_staged(const Point& a, const Point& b, const Point& c, const Point& d) {
  const int sign = filter::orientation_3(a, b, c, d);
  return sign != 0 ? Staged{sign, PredicateStage::filter} : orientation_3_exact(a, b, c, d);
}
inline Staged in_circle_2_staged(const Point& a, const Point& b, const Point& c, const Point& d) {
  const int sign = filter::in_circle_2(a, b, c, d);
  return sign != 0 ? Staged{sign, PredicateStage::filter} : in_circle_2_exact(a, b, c, d);
}
inline Staged in_sphere_3_staged(const Point& a, const Point& b, const Point& c, const Point& d, const Point& e) {
  const int sign = filter::in_sphere_3(a, b, c, d, e);
  return sign != 0 ? Staged{sign, PredicateStage::filter} : in_sphere_3_exact(a, b, c, d, e);
}

// The sign of the area of (a, b, c): positive when counterclockwise. Equals CGAL::orientation.
inline int orientation_2(const Point& a, const Point& b, const Point& c) { return orientation_2_staged(a, b, c).sign; }

// The sign of the volume of (a, b, c, d), which is det(b - a, c - a, d - a). Equals CGAL::orientation.
inline int orientation_3(const Point& a, const Point& b, const Point& c, const Point& d) {
  return orientation_3_staged(a, b, c, d).sign;
}

// Positive when d is inside the circle of the counterclockwise (a, b, c), negative when outside, 0 on the circle. The
// opposite for a clockwise (a, b, c). Equals CGAL::side_of_oriented_circle.
inline int in_circle_2(const Point& a, const Point& b, const Point& c, const Point& d) {
  return in_circle_2_staged(a, b, c, d).sign;
}

// Positive when e is inside the sphere of the positively oriented (a, b, c, d), negative when outside, 0 on the sphere.
// Equals CGAL::side_of_oriented_sphere.
inline int in_sphere_3(const Point& a, const Point& b, const Point& c, const Point& d, const Point& e) {
  return in_sphere_3_staged(a, b, c, d, e).sign;
}

// The sign of the area of (a, b, c) seen along the first of the axes z, x, y along which the area is not 0; 0 when the
// points are collinear. Within one plane the sign is an orientation, because the axis is the same for all triangles.
// Equals CGAL::coplanar_orientation.
int coplanar_orientation(const Point& a, const Point& b, const Point& c);
// Whether a, b and c lie on one line.
inline bool collinear_3(const Point& a, const Point& b, const Point& c) { return coplanar_orientation(a, b, c) == 0; }
// Positive when d is inside the circle of the triangle (a, b, c), which may have either orientation; 0 on the circle.
// REQUIRES: a, b, c are not collinear; d is coplanar with them.
int coplanar_in_circle(const Point& a, const Point& b, const Point& c, const Point& d);

// The sign that the symbolic perturbation of Devillers & Teillaud (SODA 2003) gives to a predicate that is 0. REQUIRES:
// the points are distinct.
int in_circle_tie_2(const Point& a, const Point& b, const Point& c, const Point& d);
int in_sphere_tie_3(const Point& a, const Point& b, const Point& c, const Point& d, const Point& e);

// The predicates with perturbation: never 0 for distinct points that are not all collinear (2D) or coplanar (3D).
// REQUIRES: (a, b, c) is counterclockwise, (a, b, c, d) is positively oriented.
inline int in_circle_perturbed_2(const Point& a, const Point& b, const Point& c, const Point& d) {
  const int sign = in_circle_2(a, b, c, d);
  return sign != 0 ? sign : in_circle_tie_2(a, b, c, d);
}
inline int in_sphere_perturbed_3(const Point& a, const Point& b, const Point& c, const Point& d, const Point& e) {
  const int sign = in_sphere_3(a, b, c, d, e);
  return sign != 0 ? sign : in_sphere_tie_3(a, b, c, d, e);
}
// Whether d, a point in the plane of the hull facet (a, b, c), is in conflict with the infinite cell behind it: +1 or
// -1.
// REQUIRES: a, b, c are not collinear; d is coplanar with them and distinct from them.
int coplanar_in_circle_perturbed(const Point& a, const Point& b, const Point& c, const Point& d);

}  // namespace tessera::exact
