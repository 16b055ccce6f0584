// The predicates of the flat kernel: filters on differences to the query, then exact, then the perturbation.
//
// Error bounds, with u = 2^-53, every rounded operation relative to the sum of its monomials' absolute values:
// orientation: 6 monomials x*y*z; each sees 3 differences, a product and a difference (2x2), a product and two sums:
//   8u, so 48u * X*Y*Z with X, Y, Z the largest absolute (rounded) differences per axis. 48u = 5.33e-15.
// in-sphere: 24 monomials x*y*z*w with w = x*x + y*y + z*z, which carries 5u (twice a difference, a product, two sums);
//   3 differences, 2 (2x2), 3 (3x3), 5 (w), 1 + 2 (4x4): 16u, so 384u * X*Y*Z*W. 384u = 4.263e-14.
// The constants leave room for the rounding of the bound itself and for the squares of u. Underflow adds less than
// 300 * 2^-1074 * M^4 when the differences are below M = 1e30, far below the least bound that is trusted.
#pragma once

#include <algorithm>
#include <cmath>

#include "src/base/point.h"
#include "src/kernel/kernel.h"

namespace tessera::flat {

inline constexpr double orientation_error = 5.4e-15, orientation_least = 1e-250, orientation_most = 1e60;
inline constexpr double in_sphere_error = 4.3e-14, in_sphere_least = 1e-190, in_sphere_most = 1e60;

// The sign of the volume of (p, a, b, c).
inline int orientation(const Point& p, const Point& a, const Point& b, const Point& c) {
  const double ax = a.x - p.x, ay = a.y - p.y, az = a.z - p.z;
  const double bx = b.x - p.x, by = b.y - p.y, bz = b.z - p.z;
  const double cx = c.x - p.x, cy = c.y - p.y, cz = c.z - p.z;
  const double det = ax * (by * cz - bz * cy) + bx * (cy * az - cz * ay) + cx * (ay * bz - az * by);
  const double x = std::max(std::max(std::fabs(ax), std::fabs(bx)), std::fabs(cx));
  const double y = std::max(std::max(std::fabs(ay), std::fabs(by)), std::fabs(cy));
  const double z = std::max(std::max(std::fabs(az), std::fabs(bz)), std::fabs(cz));
  const double error = orientation_error * x * y * z;
  if (std::fabs(det) > error && error > orientation_least && std::max(std::max(x, y), z) < orientation_most) [[likely]]
    return det > 0 ? 1 : -1;
  return orientation_3(p, a, b, c);
}

// in_sphere_perturbed_3 behind a filter.
inline int in_sphere(const Point& a, const Point& b, const Point& c, const Point& d, const Point& e) {
  const double ax = a.x - e.x, ay = a.y - e.y, az = a.z - e.z;
  const double bx = b.x - e.x, by = b.y - e.y, bz = b.z - e.z;
  const double cx = c.x - e.x, cy = c.y - e.y, cz = c.z - e.z;
  const double dx = d.x - e.x, dy = d.y - e.y, dz = d.z - e.z;
  const double aw = ax * ax + ay * ay + az * az, bw = bx * bx + by * by + bz * bz;
  const double cw = cx * cx + cy * cy + cz * cz, dw = dx * dx + dy * dy + dz * dz;
  const double ab = ax * by - bx * ay, bc = bx * cy - cx * by, cd = cx * dy - dx * cy, da = dx * ay - ax * dy;
  const double ac = ax * cy - cx * ay, bd = bx * dy - dx * by;
  const double abc = az * bc - bz * ac + cz * ab, bcd = bz * cd - cz * bd + dz * bc;
  const double cda = cz * da + dz * ac + az * cd, dab = dz * ab + az * bd + bz * da;
  const double det = (aw * bcd - bw * cda) + (cw * dab - dw * abc);
  const auto largest = [](double p, double q, double r, double s) {
    return std::max(std::max(std::fabs(p), std::fabs(q)), std::max(std::fabs(r), std::fabs(s)));
  };
  const double w = std::max(std::max(aw, bw), std::max(cw, dw));
  const double error =
      in_sphere_error * largest(ax, bx, cx, dx) * largest(ay, by, cy, dy) * largest(az, bz, cz, dz) * w;
  if (std::fabs(det) > error && error > in_sphere_least && w < in_sphere_most) [[likely]]
    return det > 0 ? 1 : -1;
  return in_sphere_perturbed_3(a, b, c, d, e);
}

}  // namespace tessera::flat
