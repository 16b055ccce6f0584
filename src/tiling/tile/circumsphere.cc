// Error bounds. e = 2^-53. Every operation gives the exact result times (1 + at most e), unless it underflows; then it
// is off by at most 2^-1074. With u = b - a, v = c - a, w = d - a (each component is rounded once):
//   D  = u . (v x w)                                    o = N / 2D, the centre seen from a
//   N  = |u|^2 (v x w) + |v|^2 (w x u) + |w|^2 (u x v)
// A component of a cross product is the difference of two products of once-rounded numbers. It errs by at most 2e
// (operands) + e (product) + e (difference) = 4e, plus O(e^2), times the sum of the products' absolute values. D has
// three such terms, each with one more operand (e), a product (e) and two sums (2e): 8e times P_D, which is the same
// expression with all signs positive. |u|^2 errs relatively by 2e (operands) + e + 2e = 5e. So a component of N errs by
// 5e + 4e + e + 2e = 12e times P_N. The code uses 16e for both, which also covers O(e^2) and the rounding of P itself.
// Differences are kept below 1e50, so a product that underflows (2^-1074 each) changes D or N by less than 1e-220. That
// is added to the bounds. D must exceed twice its bound; then
//   |o - o'| <= (E_N + 2 |o'| E_D) / (2 (|D| - E_D)) + e |o'|.
#include "src/tiling/tile/circumsphere.h"

#include <cmath>

#include "src/base/ieee_arithmetic.h"

namespace tessera {
namespace {

constexpr double eps = 0x1p-53;
constexpr double bound = 16 * eps;
constexpr double underflow = 1e-220;
constexpr double largest_difference = 1e50;

struct Offset {
  double value, error;
};

// Returns one component of o. `d` is D and `d_error` its bound; `n` and `n_error` are a component of N. The factor at
// the end rounds up.
Offset quotient(double n, double n_error, double d, double d_error) {
  const double o = n / (2 * d);
  const double size = std::abs(o);
  return {o, ((n_error + 2 * size * d_error) / (2 * (std::abs(d) - d_error)) + 2 * eps * size) * (1 + 8 * eps)};
}

}  // namespace

Ball circumsphere(const Point& a, const Point& b, const Point& c, const Point& d) {
  const double ux = b.x - a.x, uy = b.y - a.y, uz = b.z - a.z;
  const double vx = c.x - a.x, vy = c.y - a.y, vz = c.z - a.z;
  const double wx = d.x - a.x, wy = d.y - a.y, wz = d.z - a.z;
  const double uu = ux * ux + uy * uy + uz * uz, vv = vx * vx + vy * vy + vz * vz, ww = wx * wx + wy * wy + wz * wz;
  if (!(uu + vv + ww < largest_difference * largest_difference)) return {};

  const double vwx1 = vy * wz, vwx2 = vz * wy, vwy1 = vz * wx, vwy2 = vx * wz, vwz1 = vx * wy, vwz2 = vy * wx;
  const double wux1 = wy * uz, wux2 = wz * uy, wuy1 = wz * ux, wuy2 = wx * uz, wuz1 = wx * uy, wuz2 = wy * ux;
  const double uvx1 = uy * vz, uvx2 = uz * vy, uvy1 = uz * vx, uvy2 = ux * vz, uvz1 = ux * vy, uvz2 = uy * vx;
  const auto sum = [](double p, double q) { return std::abs(p) + std::abs(q); };
  const double vwxs = sum(vwx1, vwx2), vwys = sum(vwy1, vwy2), vwzs = sum(vwz1, vwz2);

  const double det = ux * (vwx1 - vwx2) + uy * (vwy1 - vwy2) + uz * (vwz1 - vwz2);
  const double det_error = bound * (std::abs(ux) * vwxs + std::abs(uy) * vwys + std::abs(uz) * vwzs) + underflow;
  if (!(std::abs(det) > 2 * det_error)) return {};

  const double nx = uu * (vwx1 - vwx2) + vv * (wux1 - wux2) + ww * (uvx1 - uvx2);
  const double ny = uu * (vwy1 - vwy2) + vv * (wuy1 - wuy2) + ww * (uvy1 - uvy2);
  const double nz = uu * (vwz1 - vwz2) + vv * (wuz1 - wuz2) + ww * (uvz1 - uvz2);
  const double ex = bound * (uu * vwxs + vv * sum(wux1, wux2) + ww * sum(uvx1, uvx2)) + underflow;
  const double ey = bound * (uu * vwys + vv * sum(wuy1, wuy2) + ww * sum(uvy1, uvy2)) + underflow;
  const double ez = bound * (uu * vwzs + vv * sum(wuz1, wuz2) + ww * sum(uvz1, uvz2)) + underflow;
  const Offset x = quotient(nx, ex, det, det_error), y = quotient(ny, ey, det, det_error),
               z = quotient(nz, ez, det, det_error);

  // The true centre is within e = ex + ey + ez of a + o, and the true radius is within e of |o|. So the sphere is
  // within |o| + 2e of a + o. The last terms cover the roundings of |o|, of the sums below and of a + o.
  const double error = x.error + y.error + z.error;
  const double radius = std::sqrt(x.value * x.value + y.value * y.value + z.value * z.value);
  const double reach =
      (radius + 2 * error) * (1 + 16 * eps) + 4 * eps * (std::abs(a.x) + std::abs(a.y) + std::abs(a.z) + radius);
  return {std::isfinite(reach), {a.x + x.value, a.y + y.value, a.z + z.value}, reach};
}

// The same in the plane: D = u x v, N = (|u|^2 v_y - |v|^2 u_y, |v|^2 u_x - |u|^2 v_x). There are fewer operations, so
// the bounds above hold.
Ball circumcircle(const Point& a, const Point& b, const Point& c) {
  const double ux = b.x - a.x, uy = b.y - a.y, vx = c.x - a.x, vy = c.y - a.y;
  const double uu = ux * ux + uy * uy, vv = vx * vx + vy * vy;
  if (!(uu + vv < largest_difference * largest_difference)) return {};
  const double d1 = ux * vy, d2 = uy * vx;
  const double det = d1 - d2, det_error = bound * (std::abs(d1) + std::abs(d2)) + underflow;
  if (!(std::abs(det) > 2 * det_error)) return {};
  const double x1 = uu * vy, x2 = vv * uy, y1 = vv * ux, y2 = uu * vx;
  const Offset x = quotient(x1 - x2, bound * (std::abs(x1) + std::abs(x2)) + underflow, det, det_error);
  const Offset y = quotient(y1 - y2, bound * (std::abs(y1) + std::abs(y2)) + underflow, det, det_error);
  const double error = x.error + y.error;
  const double radius = std::sqrt(x.value * x.value + y.value * y.value);
  const double reach = (radius + 2 * error) * (1 + 16 * eps) + 4 * eps * (std::abs(a.x) + std::abs(a.y) + radius);
  return {std::isfinite(reach), {a.x + x.value, a.y + y.value, 0}, reach};
}

// There is one more rounding for center -+ reach, and one for the comparison with a coordinate of the box. Both are
// covered by widening.
bool surely_inside(const Ball& ball, const Box& box, int dimension) {
  if (!ball.known) return false;
  for (int i = 0; i < dimension; ++i) {
    const double c = ball.center[i], r = ball.radius + 4 * eps * (std::abs(c) + ball.radius);
    if (!(c - r > box.lo[i] && c + r < box.hi[i])) return false;
  }
  return true;
}

}  // namespace tessera
